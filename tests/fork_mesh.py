"""A tuning fork of quadrangles in the plane, symmetric about x = 0; its tines can meet."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from small_meshes import QUADRANGLE, explicit

#: Distance between the tines in m.
SLIT = 2e-3

_TINE, _LENGTH, _BASE = 0.01, 0.1, 0.02


def fork(path: Path, *, along: int = 6, across: int = 2, right: int | None = None) -> None:
    """Write the mesh, with the groups bottom, "left tine" and "right tine" (their inner faces).

    Args:
        path: File to write.
        along: Elements along a tine.
        across: Elements across a tine.
        right: Elements along the right tine, if not as many as along the left.
    """
    nodes: dict[tuple[float, float, float], int] = {}

    def node(x: float, y: float) -> int:
        return nodes.setdefault((round(x, 12), round(y, 12), 0.0), len(nodes) + 1)

    def box(xs: np.ndarray, ys: np.ndarray) -> list[list[int]]:
        return [
            [node(a, c), node(b, c), node(b, d), node(a, d)]
            for a, b in pairwise(xs)
            for c, d in pairwise(ys)
        ]

    half = SLIT / 2
    tine = np.linspace(half, half + _TINE, across + 1)
    base = np.linspace(-_BASE, 0, 3)
    heights = [np.linspace(0, _LENGTH, count + 1) for count in (along, right or along)]
    cells = box(-tine[::-1], base) + box(np.linspace(-half, half, 3), base) + box(tine, base)
    cells += box(-tine[::-1], heights[0]) + box(tine, heights[1])
    bottom = np.concatenate([-tine[::-1], [0.0], tine])
    upper = [[y for y in ys if y > 0.4 * _LENGTH] for ys in heights]
    edges = {
        "bottom": [[node(a, -_BASE), node(b, -_BASE)] for a, b in pairwise(bottom)],
        "left tine": [[node(-half, a), node(-half, b)] for a, b in pairwise(upper[0])],
        "right tine": [[node(half, a), node(half, b)] for a, b in pairwise(upper[1])],
    }
    explicit(path, list(nodes), {QUADRANGLE: cells}, edges)


def fork_study(path: Path, **contact: Any) -> dict[str, Any]:
    """Values of a study of the fork: the tines meet each other unless told otherwise."""
    facing = {"facets": "left tine", "against": "right tine"}
    return {
        "title": "Tuning fork",
        "mesh": {"file": path.name, "length_unit": "m"},
        "body": {"theory": "plane-stress", "thickness": 0.01, "degree": 2},
        "material": {"young": 2.1e11, "poisson": 0.3, "density": 7800.0},
        "clamp": {"facets": "bottom"},
        "contact": contact or facing,
        "reduction": {"modes": 8},
        "mode": {"number": 2, "harmonics": 5, "samples": 64},
        "continuation": {"energies": {"from": 0.8, "to": 2.0, "step": 0.4}},
    }
