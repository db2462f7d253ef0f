"""Open web pages in Chromium, at the widths of a desktop and of a telephone.

Nothing may be wider than the window, no picture may be missing, and no part may be blank, on light
and on dark ground. Nothing may be asked of the network. A motion that can be turned and played must
be drawn, turn and play; without scripts its place must be empty. Runs where Chromium is:

    environment/run --viewers python3 tests/look_at_pages.py PAGE.html ... --output FOLDER
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image, ImageStat

#: Widths of windows in pixels, and the greatest height that is drawn.
WIDTHS = (1400, 390, 360)
TALLEST = 16_000

#: Spread of colours, of 255, below which the place of a live motion has nothing in it.
EMPTY = 8

#: Tells in the title of the page how large it is, what is wrong in it, and of its live motion where
#: that is, whether it can be turned and played by the keyboard.
MEASURE = """<script>
/* without a window the browser draws no frames of its own */
window.requestAnimationFrame = (act) => setTimeout(() => act(performance.now()), 16);
const pause = (time) => new Promise((done) => setTimeout(done, time));
async function live() {
  const figure = document.querySelector(".turning:not([hidden])");
  if (!figure) return null;
  const stage = figure.querySelector(".stage");
  stage.scrollIntoView();
  for (let n = 0; n < 300 && !figure.dataset.ready; n++) await pause(100);
  if (!figure.dataset.ready) return { ready: false };
  const renderers = window.global.renderWindow.getRenderers();
  const place = () => String(renderers.map((each) => each.getActiveCamera().getPosition()));
  const press = (key) => stage.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  const was = [place(), document.getElementById("live-time").value];
  press("ArrowLeft");
  press(" ");
  await pause(500);
  press(" ");
  const now = [place(), document.getElementById("live-time").value];
  scrollTo(0, 0);
  const box = stage.getBoundingClientRect();
  return { ready: true, turns: was[0] !== now[0], plays: was[1] !== now[1],
    box: [box.left, box.top, box.right, box.bottom].map(Math.round) };
}
addEventListener("load", async () => {
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
    broken: broken.map((image) => image.alt), live: await live(),
  });
});
</script></head>"""


#: Options of the browser: no window, and WebGL without a graphics card.
OPTIONS = (
    "--no-sandbox --hide-scrollbars --ignore-gpu-blocklist --use-angle=swiftshader "
    "--enable-unsafe-swiftshader"
).split()


def chromium(*arguments: str) -> str:
    """Run the browser and return what it prints."""
    command = ["chromium-headless-shell", *OPTIONS, "--virtual-time-budget=40000"]
    ended = subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=300)
    if ended.returncode:
        raise RuntimeError(f"Chromium ended with {ended.returncode}: {ended.stderr[-500:]}")
    return ended.stdout


def measured(page: Path, width: int) -> dict:
    """What the page says of its size, and of its live motion, in a window of a width."""
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


@dataclass(frozen=True, slots=True)
class Look:
    """How a page is opened.

    Attributes:
        width: Width of the window in pixels.
        height: Height of the page.
        dark: Whether on dark ground.
        scripts: Whether scripts run.
    """

    width: int
    height: int
    dark: bool = False
    scripts: bool = True

    @property
    def name(self) -> str:
        """Its part of the name of a picture."""
        return f"{self.width}_{'dark' if self.dark else 'light'}{'' if self.scripts else '_plain'}"


def drawn(page: Path, picture: Path, look: Look) -> tuple[Image.Image, list[str]]:
    """A picture of the whole page, or of its beginning, and what it asked of the network."""
    with TemporaryDirectory() as folder:
        log = Path(folder) / "log.json"
        shown = page.resolve()
        if not look.scripts:  # by the policy of the page: the browser cannot be told for itself
            shown = Path(folder) / "page.html"
            shown.write_text(re.sub(r"; script-src [^\"]*", "", page.read_text("utf-8")), "utf-8")
        chromium(
            f"--window-size={look.width},{min(look.height, TALLEST)}",
            f"--blink-settings=preferredColorScheme={0 if look.dark else 1}",
            f"--screenshot={picture}",
            f"--log-net-log={log}",
            shown.as_uri(),
        )
        asked = set(re.findall(r'"url":"((?:http|ws)s?://[^"]*)', log.read_text("utf-8")))
    with Image.open(picture) as opened:
        return opened.convert("RGB"), sorted(asked)


def faults(page: Path, folder: Path, width: int) -> list[str]:
    """What is wrong with a page in a window of a width; its pictures go to a folder."""
    told = measured(page, width)
    found = [f"wider than the window: {each}" for each in told["wide"]]
    found += [f"picture without contents: {alt}" for alt in told["broken"]]
    if told["window"] != width or told["width"] > width:
        found.append(f"{told['width']} pixels wide in a window of {told['window']}")
    looks = [Look(width, told["height"], dark) for dark in (False, True)]
    looks += [Look(width, told["height"], scripts=False)] if told["live"] else []
    for look in looks:
        name = f"{page.parent.name}_{page.stem}_{look.name}.png"
        image, asked = drawn(page, folder / name, look)
        ground = sum(image.getpixel((1, 1)))
        found += [f"{name}: blank below {top} pixels" for top in blank(image)]
        found += [f"{name}: asked for {url}" for url in asked]
        if look.dark != (ground < 200) or look.dark == (ground > 600):
            found.append(f"{name}: ground of {ground}")
        if told["live"] and look.scripts:
            found += faults_of_live(told["live"], image, name)
    return found


def faults_of_live(live: dict, image: Image.Image, name: str) -> list[str]:
    """What is wrong with a motion that can be turned and played, and with its picture."""
    if not live["ready"]:
        return ["the live motion is not drawn"]
    acts = {"turns": "does not turn", "plays": "does not play"}
    found = [f"the live motion {words}" for act, words in acts.items() if not live[act]]
    spread = max(ImageStat.Stat(image.crop(tuple(live["box"]))).stddev)
    return found + ([f"{name}: the live motion is empty"] if spread < EMPTY else [])


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
