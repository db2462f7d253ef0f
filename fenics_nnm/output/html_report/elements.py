"""Pieces of HTML from plain text, which is escaped on its way in.

`Html` is text that is HTML already; mypy keeps it apart from plain text.
"""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, NewType

Html = NewType("Html", str)


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table.

    Attributes:
        heading: What it has, with its unit.
        kind: "number", set to the right; "word", on one line; or "prose", of some width.
    """

    heading: str
    kind: Literal["number", "word", "prose"] = "number"


def text(plain: str) -> Html:
    """Plain text."""
    return Html(html.escape(plain, quote=True))


def joined(pieces: Iterable[Html], between: Html = Html("\n")) -> Html:
    """Pieces one after the other."""
    return Html(between.join(pieces))


def element(tag: str, *content: Html, **attributes: str) -> Html:
    """An element; of the names of attributes, underscores at the end are dropped."""
    return Html(f"{_opening(tag, attributes)}{''.join(content)}</{tag}>")


def void(tag: str, **attributes: str) -> Html:
    """An element that has nothing in it, and no end."""
    return Html(_opening(tag, attributes))


def paragraph(plain: str) -> Html:
    """A paragraph of plain text."""
    return element("p", text(plain))


def bullets(items: Iterable[str]) -> Html:
    """A list of plain texts."""
    return element("ul", joined(element("li", text(item)) for item in items))


def described(items: Iterable[tuple[str, str]]) -> Html:
    """A list of plain texts, each with what it is about before it."""
    return element(
        "ul",
        joined(
            element("li", element("strong", text(f"{about}: ")), text(meaning))
            for about, meaning in items
        ),
    )


def table(columns: Sequence[Column], rows: Sequence[Sequence[str]], *, label: str) -> Html:
    """A table in a box of its own, which scrolls where the window is narrow.

    Args:
        columns: Columns; those without contents in any row are left out.
        rows: Plain texts of the cells, one for each column.
        label: What the table has, for those who do not see it.
    """
    filled = [place for place in range(len(columns)) if any(row[place] for row in rows)]
    head = [
        element("th", text(columns[place].heading), class_=columns[place].kind, scope="col")
        for place in filled
    ]
    body = [element("tr", *(_cell(columns[place], row[place]) for place in filled)) for row in rows]
    inner = element(
        "table",
        element("thead", element("tr", *head)),
        element("tbody", joined(body)),
    )
    return element("div", inner, class_="scroll", role="region", aria_label=label, tabindex="0")


def facts(pairs: Iterable[tuple[str, str]]) -> Html:
    """Names and what they are."""
    items = (
        element("div", element("dt", text(name)), element("dd", text(value)))
        for name, value in pairs
    )
    return element("dl", joined(items), class_="facts")


def folded(summary: str, content: Html) -> Html:
    """Something that opens on demand."""
    return element("details", element("summary", text(summary)), content)


def link(plain: str, target: str, **attributes: str) -> Html:
    """A link."""
    return element("a", text(plain), href=target, **attributes)


def image(data: bytes, kind: str, *, alt: str, size: tuple[int, int]) -> Html:
    """A picture that is in the page itself.

    Args:
        data: Contents of its file.
        kind: Its media type.
        alt: What is seen, for those who do not see it.
        size: Width and height in pixels, for their ratio.
    """
    width, height = (str(length) for length in size)
    return Html(
        _opening("img", {"src": data_uri(data, kind), "alt": alt, "width": width, "height": height})
    )


def data_uri(data: bytes, kind: str) -> str:
    """An address that has the contents of a file in it."""
    return f"data:{kind};base64,{b64encode(data).decode()}"


def _opening(tag: str, attributes: dict[str, str]) -> str:
    named = (
        f' {name.rstrip("_").replace("_", "-")}="{text(value)}"'
        for name, value in attributes.items()
    )
    return f"<{tag}{''.join(named)}>"


def _cell(column: Column, cell: str) -> Html:
    return element("td", text(cell), class_=column.kind, data_heading=column.heading)
