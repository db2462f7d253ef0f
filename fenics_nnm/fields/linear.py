"""A file of the linear modes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.fem.blocks import Blocks
from fenics_nnm.fem.conducting import led
from fenics_nnm.fem.gathering import gathering
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.reference_cell import reference_cell
from fenics_nnm.fields.vtu import grid_file

#: Modes that are written.
_MODES = 12

#: Components within this part of the largest count as large, when the sign is chosen.
_AS_LARGE = 1e-6


def write_linear_modes(path: Path, analysis: LinearAnalysis) -> None:
    """Write the lowest mode shapes, one array a mode with its frequency in the name.

    Each shape is scaled to a largest displacement component of 1; to be called on all ranks.

    Raises:
        OSError: if it cannot be written.
    """
    way, modes = gathering(analysis.solid), analysis.modes.first(_MODES)
    nodes, cells = way.mesh()
    names = [f"mode {n + 1} ({hertz:.6g} Hz)" for n, hertz in enumerate(modes.frequencies)]

    def write(shapes: Blocks) -> None:
        grid = grid_file(nodes, cells, reference_cell(way.cell_type).written)
        blocks = (shapes.rows(few) for few in shapes.slices())
        grid.write_each(path, names, (in_space(_scaled(s)) for few in blocks for s in few))

    led(way.comm, {"shapes": way.blocks(modes.shapes)}, lambda blocks: write(blocks["shapes"]))


def _scaled(shape: Array) -> Array:
    """A shape with a largest component of 1, the first one of those that are as large."""
    size = np.abs(shape)
    first = np.argmax(size >= (1 - _AS_LARGE) * size.max())
    return shape / (size.max() * np.sign(shape.flat[first]))
