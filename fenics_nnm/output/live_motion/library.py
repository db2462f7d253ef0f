"""vtk.js as the package trame-vtk brings it: VTK for browsers, in one script.

The package is Kitware's, as VTK is. Its page for scenes in a file has vtk.js in it, which needs no
other file and no network. Where the package is not installed, reports are without a live motion.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

#: Name of the package, and its page for scenes in a file.
_PACKAGE, _PAGE = "trame-vtk", "trame_vtk/tools/static_viewer.html"

#: The script of that page, and what it must offer.
_SCRIPT = re.compile(r'<script type="module">(.*?)</script>', re.DOTALL)
_OFFERS = "window.OfflineLocalView="

#: Icons of the page that the script would load from the network, which a report never does.
_ICONS, _NO_ICON = "https://kitware.github.io/vtk-js/icon/favicon-${t}x${t}.png", "data:,"

#: Where a package has its licence.
_LICENCES = ("licenses/LICENSE", "LICENSE")


@dataclass(frozen=True, slots=True)
class Library:
    """vtk.js in one script.

    Attributes:
        script: Text of a script of the kind "module".
        notice: Package, version and licence, whose text must go with the script.
    """

    script: str
    notice: str


def installed_library() -> Library | None:
    """vtk.js if it is installed here, in a version that has what is needed; None if not."""
    try:
        package = distribution(_PACKAGE)
        page = Path(str(package.locate_file(_PAGE))).read_text("utf-8")
    except (PackageNotFoundError, OSError, UnicodeDecodeError):
        return None
    script = _SCRIPT.search(page)
    if script is None or _OFFERS not in script[1]:
        return None
    return Library(script[1].replace(_ICONS, _NO_ICON), _notice(package))


def _notice(package: Distribution) -> str:
    licences = (package.read_text(name) for name in _LICENCES)
    licence = next((text for text in licences if text), "BSD 3-clause, Kitware Inc.")
    return f"vtk.js, as in {_PACKAGE} {package.version}, without icons.\n\n{licence.strip()}"
