"""Pictures as figures that are in the page themselves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from PIL import Image

from fenics_nnm.errors import OutputError
from fenics_nnm.output.html_report.elements import Html, element, image, joined, text
from fenics_nnm.output.picture import Picture

#: Media types of the files that a page can show.
_KINDS = {".svg": "image/svg+xml", ".png": "image/png", ".gif": "image/gif"}

#: Pictures with more pixels across show several bodies, and have a row of their own.
_WIDE = 1300


@dataclass(frozen=True, slots=True)
class Gallery:
    """Pictures of a results folder.

    Attributes:
        folder: Folder of their files.
        pictures: The pictures, in their order.
    """

    folder: Path
    pictures: tuple[Picture, ...]

    def figures(self, *groups: str) -> tuple[Html, ...]:
        """The pictures of some groups, group by group, with captions.

        Raises:
            OutputError: if a file cannot be read.
        """
        chosen = [p for group in groups for p in self.pictures if p.group == group]
        figures = [self._figure(picture) for picture in chosen]
        return (element("div", joined(figures), class_="figures"),) if figures else ()

    def _figure(self, picture: Picture) -> Html:
        path = self.folder / picture.file
        try:
            data, size = path.read_bytes(), _size(path)
        except (OSError, ValueError) as error:
            raise OutputError(f"{path}: cannot be read: {error}") from error
        shown = image(data, _KINDS[path.suffix], alt=picture.title, size=size)
        caption = element(
            "figcaption", element("strong", text(f"{picture.title}. ")), text(picture.caption)
        )
        if size[0] < _WIDE:
            return element("figure", shown, caption)
        return element("figure", shown, caption, class_="wide")


def _size(path: Path) -> tuple[int, int]:
    """Width and height in pixels; in a drawing they are given in points."""
    if path.suffix == ".svg":
        lengths = ElementTree.parse(path).getroot().attrib
        width, height = (lengths[name].removesuffix("pt") for name in ("width", "height"))
        return round(float(width) * 4 / 3), round(float(height) * 4 / 3)
    with Image.open(path) as opened:
        return opened.size
