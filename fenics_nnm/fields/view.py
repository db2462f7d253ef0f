"""A ready view for ParaView: view.py, beside the motions that it opens."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.field_names import FieldName
from fenics_nnm.fields.motion import DISPLACEMENT
from fenics_nnm.fields.named import NamedMotion
from fenics_nnm.fields.stress_rows import VON_MISES
from fenics_nnm.results.stored_branch import PlacedMotion, StoredBranch

#: The largest displacement is drawn as this part of the body's size.
_DRAWN = 0.08

#: A body is looked at from so far aside and above, beside 1 across its plane.
_ASIDE, _ABOVE = 0.35, 0.25

#: A direction with more than this along z is upright.
_UPRIGHT = 0.5

_SHAPES = {1: "line", 2: "plane", 3: "solid"}


def write_view(
    folder: Path,
    branch: StoredBranch,
    motion: NamedMotion,
    fields: Sequence[FieldName],
    suffix: str,
) -> None:
    """Write view.py, which shows a motion, if there is a displacement.

    Args:
        folder: Folder of the files.
        branch: Branch.
        motion: The motion.
        fields: Fields that were written.
        suffix: How names of files of motions end.

    Raises:
        OSError: if it cannot be written.
    """
    if "displacement" not in fields:
        return
    name = motion.name
    looked, upright = _camera(branch.nodes)
    settings = {
        "MOTION": f"motion_{name}{suffix}",
        "CONTACT": f"motion_{name}_contact{suffix}" if "contact_pressure" in fields else "",
        "COLOUR": VON_MISES if "von_mises" in fields else DISPLACEMENT,
        "SCALE": _scale(branch, motion.point),
        "PLANE": _SHAPES[branch.shapes.shape[2]],
        "FROM": [round(float(x), 6) for x in looked],
        "UP": [float(x) for x in upright],
    }
    text = resources.files("fenics_nnm.fields").joinpath("view_template.py").read_text()
    for key, value in settings.items():
        text = text.replace(f'"@{key}@"', repr(value).replace("'", '"'))
    (folder / "view.py").write_text(text.replace("@WORDS@", motion.words))


def _camera(nodes: Array) -> tuple[Array, Array]:
    """Where a solid body is looked at from, and what is upwards: unit vectors, shape (3,) each.

    From across its plane, that of its two longest directions, and a little from the side and from
    above, so that its thickness is seen. Upwards is the axis nearest to the longest direction where
    it is upright, else that nearest to the second longest.
    """
    middle = nodes.mean(axis=0)
    long, wide, across = np.linalg.svd(nodes - middle, full_matrices=False)[2]
    upright = np.zeros(3)
    upright[np.argmax(np.abs(long if abs(long[2]) > _UPRIGHT else wide))] = 1.0
    aside = np.cross(upright, across)
    looked = across + _ASIDE * aside + _ABOVE * upright
    return looked / np.linalg.norm(looked), upright


def _scale(branch: StoredBranch, point: PlacedMotion) -> float:
    """A round factor that makes the largest displacement visible."""
    largest = float(branch.largest_displacement(point, 24).max())
    factor = _DRAWN * float(np.linalg.norm(np.ptp(branch.nodes, axis=0))) / largest
    digits = 10.0 ** np.floor(np.log10(factor))
    return float(f"{np.floor(factor / digits) * digits:g}")
