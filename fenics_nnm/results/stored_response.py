"""Motions of a driven structure as named arrays, as response.h5 and its journal have them.

The names are those of the file format: they stay as they are when the program names things anew.
What is not known is stored as nan or as an empty text. All texts are one array: JSON in UTF-8.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.response.levels import CurveEnd, Response
from fenics_nnm.response.peaks import Peak
from fenics_nnm.response.phase_resonance import DampedBackbone, Resonance
from fenics_nnm.response.point import Displacements, Judgement, ResponsePoint, Status

Arrays = Mapping[str, Any]
"""Arrays by their stored names."""

#: Numbers of a motion by their stored names.
_NUMBERS: dict[str, Callable[[ResponsePoint], float]] = {
    "frequency": lambda point: point.frequency,
    "level": lambda point: point.level,
    "branch": lambda point: point.branch,
    "speed": lambda point: point.speed,
    "residual": lambda point: point.residual,
    "imbalance": lambda point: point.imbalance,
    "largest_multiplier": lambda point: point.judgement.largest_multiplier,
}

#: Texts of a motion by their stored names.
_TEXTS: dict[str, Callable[[ResponsePoint], str]] = {
    "status": lambda point: str(point.status),
    "reason": lambda point: point.reason,
    "stability": lambda point: point.judgement.stability,
    "event": lambda point: point.event,
}

#: Arrays of a motion by their stored names.
_ARRAYS: dict[str, Callable[[ResponsePoint], Any]] = {
    "q": lambda point: point.q,
    "first": lambda point: point.displacements.first,
    "highest": lambda point: point.displacements.highest,
    "lowest": lambda point: point.displacements.lowest,
    "contact": lambda point: point.displacements.contact,
    "gap": lambda point: point.displacements.gap,
}

_OF_PEAKS = ("monitor", "frequency", "amplitude", "phase", "level")


def packed(found: Response) -> dict[str, Any]:
    """Motions of some levels with their peaks and reasons; not the damped backbone."""
    reasons = [[each.level, each.reason] for each in found.reasons]
    texts: dict[str, list[Any]] = {**_texts_of(found.points), "reasons": reasons}
    peaks = [[float(getattr(peak, name)) for name in _OF_PEAKS] for peak in found.peaks]
    return {
        **_points_of(found.points),
        "peaks": np.reshape(peaks, (-1, len(_OF_PEAKS))),
        "texts": _encoded(texts),
    }


def unpacked(arrays: Arrays) -> Response:
    """The motions of stored arrays.

    Raises:
        KeyError, ValueError: if one is missing or of another kind.
    """
    texts = _decoded(arrays["texts"])
    return Response(
        points=_points(arrays, texts),
        peaks=tuple(_peak(*map(float, row)) for row in arrays["peaks"]),
        reasons=tuple(CurveEnd(reason, float(level)) for level, reason in texts["reasons"]),
    )


def _peak(monitor: float, *numbers: float) -> Peak:
    return Peak(int(monitor), *numbers)


def packed_backbone(backbone: DampedBackbone) -> dict[str, Any]:
    """Motions in phase resonance."""
    points = [each.point for each in backbone.points]
    return {
        **_points_of(points),
        "force": np.array([each.force for each in backbone.points]),
        "damping_ratio": np.array([each.damping_ratio for each in backbone.points]),
        "texts": _encoded(_texts_of(points) | {"reasons": list(backbone.reasons)}),
    }


def unpacked_backbone(arrays: Arrays) -> DampedBackbone:
    """The motions in phase resonance of stored arrays.

    Raises:
        KeyError, ValueError: if one is missing or of another kind.
    """
    texts = _decoded(arrays["texts"])
    columns = (_points(arrays, texts), arrays["force"], arrays["damping_ratio"])
    found = (
        Resonance(point, float(force), float(ratio))
        for point, force, ratio in zip(*columns, strict=True)
    )
    return DampedBackbone(tuple(found), tuple(texts["reasons"]))


def _points_of(points: Sequence[ResponsePoint]) -> dict[str, Array | Indices]:
    numbers = {name: np.array([of(p) for p in points], float) for name, of in _NUMBERS.items()}
    arrays = {name: np.array([of(p) for p in points]) for name, of in _ARRAYS.items()}
    return {**numbers, **arrays}


def _texts_of(points: Sequence[ResponsePoint]) -> dict[str, list[str]]:
    return {name: [of(point) for point in points] for name, of in _TEXTS.items()}


def _points(arrays: Arrays, texts: Mapping[str, list[Any]]) -> tuple[ResponsePoint, ...]:
    count = len(texts["status"])
    numbers = {name: np.array(arrays[name]) for name in (*_NUMBERS, *_ARRAYS)}
    if any(len(values) != count for values in numbers.values()):
        raise ValueError("numbers of motions differ")
    rows = ({name: values[n] for name, values in numbers.items()} for n in range(count))
    words = ({name: texts[name][n] for name in _TEXTS} for n in range(count))
    return tuple(_point(row, said) for row, said in zip(rows, words, strict=True))


def _point(row: Arrays, said: Mapping[str, str]) -> ResponsePoint:
    return ResponsePoint(
        frequency=float(row["frequency"]),
        judgement=Judgement(
            Status(said["status"]),
            said["reason"],
            float(row["largest_multiplier"]),
            said["stability"],
        ),
        displacements=Displacements(
            **{name: row[name] for name in ("first", "highest", "lowest", "contact", "gap")}
        ),
        residual=float(row["residual"]),
        q=row["q"],
        level=float(row["level"]),
        branch=int(row["branch"]),
        imbalance=float(row["imbalance"]),
        event=said["event"],
        speed=float(row["speed"]),
    )


def _encoded(texts: Mapping[str, list[Any]]) -> Array:
    return np.frombuffer(json.dumps(texts).encode(), dtype=np.uint8)


def _decoded(values: Any) -> dict[str, list[Any]]:
    return dict(json.loads(np.asarray(values, dtype=np.uint8).tobytes()))
