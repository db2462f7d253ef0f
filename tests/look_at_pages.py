"""Open web pages in Chromium, at the widths of a desktop and of a telephone.

Nothing may be wider than the window, no picture may be missing, and no part may be blank, on light
and on dark ground. Runs where Chromium is:

    environment/run --viewers python3 tests/look_at_pages.py PAGE.html ... --output FOLDER
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image, ImageStat

#: Widths of windows in pixels, and the greatest height that is drawn.
WIDTHS = (1400, 390, 360)
TALLEST = 16_000

#: Tells in the title of the page how large it is, and what is wrong in it.
MEASURE = """<script>
addEventListener("load", () => {
  const root = document.documentElement, window_width = root.clientWidth;
  const scrolls = (node) => node && (/auto|scroll/.test(getComputedStyle(node).overflowX)
    || scrolls(node.parentElement));
  const beyond = (node) => node.getBoundingClientRect().right > window_width + 1;
  const wide = [...document.querySelectorAll("body *")].filter((node) =>
    beyond(node) && !beyond(node.parentElement) && !scrolls(node.parentElement));
  const broken = [...document.images].filter((image) => !image.naturalWidth);
  document.title = JSON.stringify({
    window: window_width, width: root.scrollWidth, height: root.scrollHeight,
    wide: wide.map((node) => node.tagName + " " + node.textContent.slice(0, 40)),
    broken: broken.map((image) => image.alt),
  });
});
</script></head>"""


def chromium(*arguments: str) -> str:
    """Run the browser and return what it prints."""
    command = ["chromium-headless-shell", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    ended = subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=120)
    if ended.returncode:
        raise RuntimeError(f"Chromium ended with {ended.returncode}: {ended.stderr[-500:]}")
    return ended.stdout


def measured(page: Path, width: int) -> dict:
    """What the page says of its size in a window of a width."""
    with TemporaryDirectory() as folder:
        probe = Path(folder) / "page.html"
        text = re.sub(
            r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", page.read_text("utf-8")
        )
        probe.write_text(text.replace("</head>", MEASURE, 1), "utf-8")
        dom = chromium(f"--window-size={width},900", "--dump-dom", probe.as_uri())
    told = re.search(r"<title>(\{.*?\})</title>", dom, re.DOTALL)
    if told is None:
        raise RuntimeError(f"{page}: Chromium tells no sizes")
    return json.loads(told.group(1).replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">"))


def drawn(page: Path, picture: Path, width: int, height: int, *, dark: bool) -> Image.Image:
    """A picture of the whole page, or of its beginning."""
    chromium(
        f"--window-size={width},{min(height, TALLEST)}",
        f"--blink-settings=preferredColorScheme={0 if dark else 1}",
        f"--screenshot={picture}",
        page.resolve().as_uri(),
    )
    with Image.open(picture) as opened:
        return opened.convert("RGB")


def faults(page: Path, folder: Path, width: int) -> list[str]:
    """What is wrong with a page in a window of a width; its pictures go to a folder."""
    told = measured(page, width)
    found = [f"wider than the window: {each}" for each in told["wide"]]
    found += [f"picture without contents: {alt}" for alt in told["broken"]]
    if told["window"] != width or told["width"] > width:
        found.append(f"{told['width']} pixels wide in a window of {told['window']}")
    ground = {}
    for dark in (False, True):
        name = f"{page.parent.name}_{page.stem}_{width}_{'dark' if dark else 'light'}.png"
        image = drawn(page, folder / name, width, told["height"], dark=dark)
        ground[dark] = sum(image.getpixel((1, 1)))
        found += [f"{name}: blank below {top} pixels" for top in blank(image)]
    if not ground[True] < 200 < 600 < ground[False]:
        found.append(f"ground of {ground[False]} in light and {ground[True]} in dark")
    return found


def blank(image: Image.Image, band: int = 1000) -> list[int]:
    """Where bands of a picture begin that have nothing in them."""
    tops = range(0, image.height - band // 2, band)
    bands = ((top, image.crop((0, top, image.width, top + band))) for top in tops)
    return [top for top, part in bands if max(ImageStat.Stat(part).stddev) < 3]


def main() -> int:
    """Look at all pages and tell what is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", type=Path, nargs="+", metavar="PAGE.html")
    parser.add_argument("--output", type=Path, required=True, help="folder of the pictures")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    found = 0
    for page in arguments.pages:
        for width in WIDTHS:
            wrong = faults(page, arguments.output, width)
            found += len(wrong)
            sys.stdout.write(f"{page} at {width} pixels: {'; '.join(wrong) or 'well'}\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
