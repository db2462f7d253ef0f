"""The same mesh through the files of several programs gives the same frequencies."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import foreign_files
import numpy as np
import pytest
from conftest import BEAM, PLATE, changed
from mpi4py import MPI

from fenics_nnm.errors import MeshError
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from


def frequencies(path: Path, left: str, right: str) -> Any:
    """Frequencies in Hz and contact area in m^2 of a box clamped on its left."""
    base = BEAM if "3d" in path.stem else PLATE
    study = changed(
        base,
        {
            "mesh": {"=": {"file": str(path), "length_unit": "m"}},
            "clamp": {"facets": left},
            "contact": {"facets": right},
            "reduction": {"modes": 4},
        },
    )
    linear = linear_analysis(study_from(study, path), MPI.COMM_SELF)
    return [*linear.modes.frequencies, linear.interface.areas.sum()]


def box(tmp_path: Path, shape: str, order: int, *, complete: bool = True) -> Path:
    path = tmp_path / f"box{foreign_files.SHAPES[shape]}d.msh"
    foreign_files.box(path, shape, order, complete=complete)
    return path


@cache
def first_frequencies(shape: str, order: int, *, complete: bool) -> Any:
    """Those of the file of gmsh, once for all formats."""
    with TemporaryDirectory() as folder:
        return frequencies(box(Path(folder), shape, order, complete=complete), "left", "right")


FORMATS = [
    *(("inp", shape, order) for shape in foreign_files.SHAPES for order in (1, 2)),
    *(("bdf", shape, order) for shape in ("tetra", "hexahedron") for order in (1, 2)),
    *(("vtu", shape, order) for shape in foreign_files.SHAPES for order in (1, 2)),
    *(("med", shape, order) for shape in foreign_files.SHAPES for order in (1, 2)),
    *(("unv", shape, order) for shape in ("tetra", "hexahedron") for order in (1, 2)),
]


@pytest.mark.parametrize(("ending", "shape", "order"), FORMATS)
def test_same_frequencies_from_another_file(
    ending: str, shape: str, order: int, tmp_path: Path
) -> None:
    """Elements without inner nodes (8 or 20 nodes) where the format has no others."""
    complete = ending == "vtu"
    msh = box(tmp_path, shape, order, complete=complete)
    other = msh.with_suffix(f".{ending}")
    foreign_files.WRITERS[ending](msh, other)
    names = foreign_files.NAMES.get(ending, ("left", "right"))
    expected = first_frequencies(shape, order, complete=complete)
    np.testing.assert_allclose(frequencies(other, *names), expected, rtol=1e-10)


def test_universal_file_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    """What is left has cells enough for a body, which is another one."""
    file = tmp_path / "box.unv"
    foreign_files.WRITERS["unv"](box(tmp_path, "tetra", 1, complete=False), file)
    lines = file.read_text().splitlines(keepends=True)
    marks = [number for number, line in enumerate(lines) if line.strip() == "-1"]
    file.write_text("".join(lines[: marks[3] - 4]))
    with pytest.raises(MeshError, match="ends within a dataset"):
        frequencies(file, "left", "right")
