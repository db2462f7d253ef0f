"""A ready view for ParaView: view.py, beside the motions that it opens."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from pathlib import Path

import numpy as np

from fenics_nnm.field_names import FieldName
from fenics_nnm.fields.motion import DISPLACEMENT
from fenics_nnm.fields.named import NamedMotion
from fenics_nnm.fields.stress_rows import VON_MISES
from fenics_nnm.results.stored_branch import PlacedMotion, StoredBranch

#: The largest displacement is drawn as this part of the body's size.
_DRAWN = 0.08

_SHAPES = {1: "line", 2: "plane", 3: "solid"}


def write_view(
    folder: Path,
    branch: StoredBranch,
    motion: NamedMotion,
    fields: Sequence[FieldName],
) -> None:
    """Write view.py, which shows a motion, if there is a displacement.

    Args:
        folder: Folder of the files.
        branch: Branch.
        motion: The motion.
        fields: Fields that were written.

    Raises:
        OSError: if it cannot be written.
    """
    if "displacement" not in fields:
        return
    name = motion.name
    settings = {
        "MOTION": f"motion_{name}.pvd",
        "CONTACT": f"motion_{name}_contact.pvd" if "contact_pressure" in fields else "",
        "COLOUR": VON_MISES if "von_mises" in fields else DISPLACEMENT,
        "SCALE": _scale(branch, motion.point),
        "PLANE": _SHAPES[branch.shapes.shape[2]],
    }
    text = resources.files("fenics_nnm.fields").joinpath("view_template.py").read_text()
    for key, value in settings.items():
        text = text.replace(f'"@{key}@"', repr(value).replace("'", '"'))
    (folder / "view.py").write_text(text.replace("@WORDS@", motion.words))


def _scale(branch: StoredBranch, point: PlacedMotion) -> float:
    """A round factor that makes the largest displacement visible."""
    largest = float(branch.largest_displacement(point, 24).max())
    factor = _DRAWN * float(np.linalg.norm(np.ptp(branch.nodes, axis=0))) / largest
    digits = 10.0 ** np.floor(np.log10(factor))
    return float(f"{np.floor(factor / digits) * digits:g}")
