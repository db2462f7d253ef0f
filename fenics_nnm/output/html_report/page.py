"""The page as a whole: head, table of contents, sections."""

from __future__ import annotations

import hashlib
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Template

from fenics_nnm.errors import OutputError
from fenics_nnm.output.html_report.elements import Html, bullets, element, joined, link, text
from fenics_nnm.output.html_report.style import STYLE
from fenics_nnm.results.durable import write_whole

_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="$policy">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="$generator">
<link rel="icon" href="data:,">
<title>$title</title>
<style>$style</style>
</head>
<body>
<header>
<p class="kicker">$kicker</p>
<h1>$title</h1>
</header>
<nav aria-label="Contents">
<h2>Contents</h2>
$contents
</nav>
<main>
$sections
</main>
<footer>$footer</footer>
</body>
</html>
""")


#: What a browser may load: pictures and styles that are in the page, and nothing from elsewhere.
POLICY = (
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; "
    "form-action 'none'"
)


@dataclass(frozen=True, slots=True)
class Script:
    """A script that is in the page itself, and may run there: any other may not.

    Attributes:
        text: Its text, to the letter.
    """

    text: str

    @property
    def source(self) -> str:
        """What a Content-Security-Policy calls it: the digest of its text."""
        digest = b64encode(hashlib.sha256(self.text.encode()).digest()).decode()
        return f"'sha256-{digest}'"


def policy_with(scripts: Sequence[Script]) -> str:
    """What a browser may load of a page with some scripts."""
    if not scripts:
        return POLICY
    return f"{POLICY}; script-src {' '.join(script.source for script in scripts)}"


@dataclass(frozen=True, slots=True)
class Section:
    """A part of the page with a heading.

    Attributes:
        key: Name that links lead to.
        title: Heading.
        content: What it has; nothing if there is nothing to show.
        absent: Why it has nothing; named in the last section then.
    """

    key: str
    title: str
    content: tuple[Html, ...]
    absent: str = ""


def page(
    *,
    title: str,
    kicker: str,
    generator: str,
    footer: str,
    sections: Sequence[Section],
    scripts: Sequence[Script] = (),
) -> str:
    """The text of the page.

    Args:
        title: Its title.
        kicker: A line above the title.
        generator: Name and version of the program.
        footer: The last line.
        sections: Its sections; a last one says why those without content are not there.
        scripts: Scripts that are in the sections.
    """
    shown = [section for section in sections if section.content]
    absent = [f"{s.title}: {s.absent}" for s in sections if not s.content]
    if absent:
        shown.append(Section("absent", "Not in this report", (bullets(absent),)))
    return _PAGE.substitute(
        title=text(title),
        kicker=text(kicker),
        generator=text(generator),
        footer=text(footer),
        style=STYLE,
        policy=policy_with(scripts),
        contents=_contents(shown),
        sections=joined(_drawn(section) for section in shown),
    )


def _contents(sections: Sequence[Section]) -> Html:
    return element("ol", *(element("li", link(s.title, f"#{s.key}")) for s in sections))


def _drawn(section: Section) -> Html:
    heading = element("h2", text(section.title), id=f"{section.key}-heading")
    return element(
        "section",
        heading,
        joined(section.content),
        id=section.key,
        aria_labelledby=f"{section.key}-heading",
    )


def write_page(file: Path, written: str) -> None:
    """Write a page, with the folder that it is in.

    Raises:
        OutputError: if it cannot be written; an older page is as it was then.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, written.encode())
    except OSError as error:
        raise OutputError(f"{file}: cannot be written: {error.strerror or error}") from error
