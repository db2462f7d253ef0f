"""Small studies that have the sections of loads, rigid facets, large deflection and matrices."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from conftest import BEAM, PLATE, ROD

#: What all have in common: few modes, harmonics and energies.
_COMMON = {key: ROD[key] for key in ("reduction", "mode", "continuation")}

#: Two cubes of a beam along x, with sets of nodes at its root and above it.
_NODES = [(x, y, z) for x in (0.0, 0.5, 1.0) for y in (0.0, 0.15) for z in (0.0, 0.1)]
_INP = "\n".join(
    [
        "*NODE",
        *(f"{i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(_NODES, 1)),
        "*ELEMENT, TYPE=C3D8, ELSET=body",
        "1, 1, 5, 7, 3, 2, 6, 8, 4",
        "2, 5, 9, 11, 7, 6, 10, 12, 8",
        "*NSET, NSET=low\n1, 3\n*NSET, NSET=high\n2, 4\n",
    ]
)

#: A beam of a mesh file, held by its nodes, hot, at speed, under forces, which bends far.
LOADED: dict[str, Any] = {
    **BEAM,
    "length_unit": "m",
    "mesh": {"file": "m.inp"},
    "groups": {"left": {"x": 0.0}, "right": {"x": 1.0}, "top": {"z": "100 mm"}},
    "body": {"theory": "solid", "degree": 1, "kinematics": "second-order", "masters": [1, 2]},
    "material": {**BEAM["material"], "expansion": 1.2e-5},
    "clamp": [{"nodes": ["low", "high"]}, {"facets": "left", "directions": ["x"]}],
    "rotation": {"axis": "z", "origin": [0.0, 0.0, 0.0], "speed": 10.0, "coriolis": False},
    "load": {
        "temperature": 300.0,
        "reference_temperature": 293.15,
        "pressure": [{"facets": "top", "pressure": 100.0, "follower": True}],
        "force": [{"at": [1.0, 0.0, 0.1], "force": [0.0, 0.0, 1.0]}],
    },
}

#: A beam within a casing that grows at speed, which bends if it matters; speed in turns per minute.
CASED: dict[str, Any] = {
    **BEAM,
    "body": {"theory": "solid", "degree": 1, "kinematics": "auto"},
    "rotation": {"axis": [0.0, 1.0, 0.0], "rpm": 100.0},
    "load": {"force": [{"facets": "top", "force": [0.0, 0.0, 1.0]}]},
    "contact": {
        "facets": "right",
        "direction": "radial",
        "axis": "y",
        "casing": {"shape": "cylinder", "axis": "y", "radius": "1020 mm", "growth": 1e-5},
        "points": 2,
    },
}

#: A beam with a rigid end; its upper side can touch.
RIGID: dict[str, Any] = {
    **BEAM,
    "body": {"theory": "solid", "degree": 1},
    "groups": {"pad": {"box": {"from": [0.3, 0.0, 0.1], "to": [0.7, 0.15, 0.1]}}},
    "contact": {**BEAM["contact"], "facets": "pad", "points": 2},
    "rigid": [
        {
            "facets": "right",
            "at": [1.0, 0.0, 0.0],
            "mass": 0.1,
            "inertia": [0.01, 0.01, 0.01],
            "directions": ["rx"],
        }
    ],
}


def _arrays() -> bytes:
    """A .npz file of three masses on springs, with all further arrays."""
    n = 3
    third = np.zeros((n, n, n))
    third[0, 0, 0] = third[1, 1, 1] = 1e3
    fourth = np.zeros((n, n, n, n))
    fourth[0, 0, 0, 0] = 1e8
    rows = np.zeros((1, n, n))
    rows[0, 2, 2] = 0.1
    text = io.BytesIO()
    stiffness = 1e5 * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    arrays: dict[str, Any] = {"K": stiffness, "M": np.eye(n), "B": np.eye(n)[2:], "S": np.eye(n)}
    arrays["G"] = np.eye(n, k=1) - np.eye(n, k=-1)
    np.savez(text, **arrays, K2=third, K3=fourth, B2=rows)
    return text.getvalue()


#: Three masses at speed with quadratic and cubic forces and a closing that is quadratic.
BENT: dict[str, Any] = {
    **_COMMON,
    "matrices": {
        "file": "a.npz",
        "speed": 10.0,
        "masters": [1],
        "speed_stiffness": "S",
        "gyroscopic": "G",
        "coriolis": False,
        "quadratic_stiffness": "K2",
        "cubic_stiffness": "K3",
        "quadratic_rows": "B2",
    },
    "contact": {"gap": ["1 mm"], "gap_growth": [1e-7]},
}

#: A rod and a plate with temperatures that change from place to place.
WARM: dict[str, Any] = {
    **ROD,
    "material": {**ROD["material"], "expansion": 1.2e-5},
    "load": {"temperature_field": {"shape": "table", "file": "t.csv", "outside": "1 mm"}},
}
LINEAR: dict[str, Any] = {
    **PLATE,
    "body": {**PLATE["body"], "degree": 1},
    "material": {**PLATE["material"], "expansion": 1.2e-5},
    "load": {
        "temperature_field": {
            "shape": "linear",
            "temperature": 300.0,
            "at": [0.0, 0.0],
            "gradient": [10.0, 1.0],
        },
        "reference_temperature": 290.0,
    },
}

#: Files beside the studies.
FILES = {"m.inp": _INP.encode(), "a.npz": _arrays(), "t.csv": b"x_mm,T_C\n0,20\n600,90\n1000,30\n"}

#: The sections and keys that the studies are there for.
NEW: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "loaded": (LOADED, ("length_unit", "body", "material", "clamp", "rotation", "load")),
    "cased": (CASED, ("rotation", "contact")),
    "rigid": (RIGID, ("rigid",)),
    "warm": (WARM, ("load",)),
    "linear": (LINEAR, ("load",)),
    "bent": (BENT, ("matrices", "contact")),
}

#: Options of fenics-nnm campbell with values that are none.
CAMPBELL: tuple[tuple[str, str], ...] = (
    *(("--speeds", value) for value in ("", "1", "0:1:0", "1:0:1", "0:nan:1", "0:inf:1")),
    *(("--speeds", value) for value in ("0:1e300:1e299", "0:1e9:1", "0:10:1e-300", "a:b:c")),
    *(("--speeds", value) for value in ("0:1e-300:1e-300", "0:1e300:1", "-1:1:1", "0:1e6:5e5")),
    *(("--modes", value) for value in ("0", "-1", "1e3", "2147483648", "10000", "x", "")),
    *(("--orders", value) for value in ("", "0", "-1", "1,1", "1e3", "9" * 5000, "1,2;3", "²")),
    *(("--energies", value) for value in ("0", "-1", "nan", "1e300", "1e-300", "x", "1,1", "1,,")),
    *(("--amplitudes", value) for value in ("0", "-1 mm", "1 furlong", "1e300", "nan", "9" * 5000)),
    *(("--jobs", value) for value in ("0", "-1", "x", "", "1.5", "nan", "9" * 5000)),
    *(("--output", value) for value in ("", ".", "s.toml", "/proc/x", "a/" * 3000, "\u202e")),
)
