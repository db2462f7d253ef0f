"""Shapes on their way to branch.h5: some rows at a time, and the same whatever their number."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from conftest import PLATE, Ended
from ranks import on_ranks

import fenics_nnm.fem.blocks
import fenics_nnm.fem.gathering
from fenics_nnm.fem.linear import LinearAnalysis

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: Bytes of a displacement of the small plate.
OF_SHAPE = 8 * 2 * 27

#: Runs a study with blocks of three shapes, and tells the most that came to one rank at once.
LARGEST = """
import sys
from mpi4py import MPI
import fenics_nnm.fem.blocks
import fenics_nnm.fem.gathering as gathering
from fenics_nnm.cli import main

fenics_nnm.fem.blocks.AT_ONCE = {at_once}
largest, gathered = 0, gathering._gathered

def noted(comm, own):
    global largest
    whole = gathered(comm, own)
    if own.dtype == float and own.ndim == 3:
        largest = max(largest, whole.nbytes)
    return whole

gathering._gathered = noted
code = main(sys.argv[1:])
told = MPI.COMM_WORLD.gather(largest)
if told:
    print(told)
sys.exit(code)
"""


def test_shapes_are_those_of_the_degrees_of_freedom(
    plate_analysis: LinearAnalysis, monkeypatch: Any
) -> None:
    """Against values at the places of the nodes, which no block has a say in."""
    data = fenics_nnm.fem.gathering.gathered_basis(plate_analysis)
    places: Any = data.arrays["mesh/points"]
    space = plate_analysis.solid.space
    own = space.tabulate_dof_coordinates()
    row = [int(np.argmin(np.linalg.norm(own - place, axis=1))) for place in places]
    columns = plate_analysis.reduction.shapes
    for rows in (1, 3, 100):
        monkeypatch.setattr(fenics_nnm.fem.blocks, "AT_ONCE", rows * 8 * columns.shape[0])
        shapes: Any = data.blocks["basis/shapes"]
        slices = list(shapes.slices())
        assert max(few.stop - few.start for few in slices) == min(rows, columns.shape[1])
        found = np.concatenate([shapes.rows(few) for few in slices])
        assert shapes.shape == found.shape
        assert np.array_equal(found, columns.T.reshape(len(found), -1, 2)[:, row])


def test_two_ranks_write_the_shapes_of_one(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(PLATE, reduction={"modes": 6})
    assert command("run", study, "--output", "one").code == 0
    script = tmp_path / "largest.py"
    script.write_text(LARGEST.format(at_once=2 * OF_SHAPE))
    ended = on_ranks(2, script, "run", study, "--output", "two", folder=tmp_path)
    assert ended.code == 0, ended.err
    # six modes and three residual shapes, and the modes of a file of their own: two at once
    assert ended.out.splitlines()[-1] == f"[{2 * OF_SHAPE}, 0]"
    with h5py.File(tmp_path / "one/branch.h5") as one, h5py.File(tmp_path / "two/branch.h5") as two:
        for name in ("mesh/cells", "mesh/region", "material/row", "contact/facets"):
            assert np.array_equal(one[name][:], two[name][:]), name
        for name in ("basis/shapes", "basis/residual_shapes", "material/elasticity"):
            first, second = one[name][:], two[name][:]
            assert first.shape == second.shape
            assert np.abs(second - first).max() == pytest.approx(0, abs=1e-8 * np.abs(first).max())
