"""Pictures as figures that are in the page themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from PIL import Image

from fenics_nnm.errors import OutputError
from fenics_nnm.output.gallery import Picture
from fenics_nnm.output.html_report.elements import Html, element, image, joined, text

#: Media types of the files that a page can show.
_KINDS = {".svg": "image/svg+xml", ".png": "image/png", ".gif": "image/gif"}

#: Pictures that are wider than so many times their height have a row of their own.
_WIDE = 1.8

#: Drawings with more bytes than this are shown as pixels, where there are some.
_LARGEST_DRAWING = 400_000


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
        """The pictures of some groups with captions, side by side where there is room.

        Raises:
            OutputError: if a file cannot be read.
        """
        figures = [self._figure(p) for p in self.pictures if p.group in groups]
        return (element("div", joined(figures), class_="figures"),) if figures else ()

    def _figure(self, picture: Picture) -> Html:
        path = self._chosen((picture.file, *picture.also))
        try:
            data, size = path.read_bytes(), _size(path)
        except (OSError, ValueError) as error:
            raise OutputError(f"{path}: cannot be read: {error}") from error
        shown = image(data, _KINDS[path.suffix], alt=picture.title, size=size)
        caption = element("strong", text(f"{picture.title}. "))
        width, height = size
        return element(
            "figure",
            shown,
            element("figcaption", caption, text(picture.caption)),
            **({"class_": "wide"} if width > _WIDE * height else {}),
        )

    def _chosen(self, files: Sequence[str]) -> Path:
        """The file to show: a drawing that is not too large, or else pixels."""
        paths = [self.folder / file for file in files if Path(file).suffix in _KINDS]
        drawings = [path for path in paths if path.suffix == ".svg"]
        small = [path for path in drawings if path.stat().st_size <= _LARGEST_DRAWING]
        return next(iter([*small, *(p for p in paths if p not in drawings), *drawings]))


def _size(path: Path) -> tuple[int, int]:
    """Width and height in pixels; in a drawing they are given in points."""
    if path.suffix == ".svg":
        lengths = ElementTree.parse(path).getroot().attrib
        width, height = (lengths[name].removesuffix("pt") for name in ("width", "height"))
        return round(float(width) * 4 / 3), round(float(height) * 4 / 3)
    with Image.open(path) as opened:
        return opened.size
