"""Small random studies; as a program it runs many of them and tells how they end."""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from collections import Counter
from itertools import zip_longest
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from conftest import toml
from study_outcome import Examiner, Outcome

from fenics_nnm.backbone.point import VERIFIED

Section = dict[str, Any]

#: Studies of the verification report.
WHOLE = 200


def write_study(number: int, folder: Path) -> Path:
    """Write the random study of a number, and the files that it names, to a folder."""
    chance = Random(f"study {number}")
    folder.mkdir(parents=True, exist_ok=True)
    study = _matrices(chance, folder) if chance.random() < 0.25 else _mesh(chance)
    study["mode"] = _mode(chance)
    study["reduction"] = _reduction(chance, of_mesh="mesh" in study)
    study["mode"]["number"] = min(study["mode"]["number"], study["reduction"]["modes"])
    method = study["reduction"]["method"]
    if method == "none" and chance.random() < 0.3:
        study["contact"]["law"] = method = "augmented-lagrangian"
    with_mass = method in ("craig-bampton", "augmented-lagrangian")
    study["continuation"] = _continuation(chance, with_mass=with_mass)
    if method == "massless":
        _press(Random(f"gaps of {number}"), study["contact"], study["continuation"])
    path = folder / "study.toml"
    path.write_text(toml({"title": f"Random study {number}", **study}))
    return path


def _mesh(chance: Random) -> dict[str, Section]:
    length = _spread(chance, 1e-3, 1e2)
    body = chance.choice([_rod, _plate, _plate, _beam])(chance, length)
    body["material"] = {
        "young": _spread(chance, 1e6, 1e12),
        "poisson": chance.choice([0.0, 0.2, 0.3, 0.45]),
        "density": _spread(chance, 100.0, 2e4),
    }
    body["contact"]["gap"] = length * _spread(chance, 1e-6, 10.0)
    return body


def _rod(chance: Random, length: float) -> dict[str, Section]:
    held, free = chance.choice([("left", "right"), ("right", "left")])
    outward = 1.0 if free == "right" else -1.0
    return {
        "mesh": {**_named("rod", length), "elements": chance.randint(2, 25)},
        "body": {
            "theory": "rod",
            "area": _spread(chance, 1e-6, 1e-2),
            "degree": chance.choice([1, 2]),
        },
        "clamp": {"facets": held},
        "contact": {"facets": free, "direction": chance.choice(["normal", [outward]])},
    }


def _plate(chance: Random, length: float) -> dict[str, Section]:
    held, free, normal = chance.choice(
        [("left", "right", (1, 0)), ("right", "left", (-1, 0)), ("bottom", "top", (0, 1))]
    )
    height = length * chance.uniform(0.15, 1.2)
    oblique = [component + chance.uniform(-0.8, 0.8) for component in normal]
    across = [[0.0, 1.0], [1.0, 0.0]][abs(normal[1])]
    direction = chance.choice(["normal", oblique, across, across, "radial"])
    contact = {"facets": free, "direction": direction, "points": chance.choice(["all", 1, 2, 3])}
    if direction == "radial":
        far = chance.uniform(1.0, 4.0) * length
        contact |= {"axis": "z", "origin": [-far * normal[0], -far * normal[1]]}
    return {
        "mesh": {
            **_named("plate", length),
            "height": height,
            "elements": [chance.randint(2, 8), chance.randint(1, 4)],
            "cells": chance.choice(["quadrilateral", "triangle"]),
        },
        "body": {
            "theory": chance.choice(["plane-stress", "plane-strain"]),
            "thickness": _spread(chance, 1e-4, 0.1),
            "degree": chance.choice([1, 2]),
        },
        "clamp": {"facets": held},
        "contact": contact,
    }


def _beam(chance: Random, length: float) -> dict[str, Section]:
    width, height = (length * chance.uniform(0.1, 0.4) for _ in range(2))
    vector = [chance.uniform(-1.0, 1.0) for _ in range(3)]
    direction = chance.choice(["normal", [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], vector, "radial"])
    contact = {"facets": "right", "direction": direction, "points": chance.choice(["all", 1, 2, 3])}
    if direction == "radial":
        contact |= {"axis": "x", "origin": [0.0, -width, -height]}
    return {
        "mesh": {
            **_named("beam", length),
            "width": width,
            "height": height,
            "elements": [chance.randint(2, 5), 1, chance.randint(1, 2)],
            "cells": chance.choice(["hexahedron", "tetrahedron"]),
            "tip_scale": chance.choice([1.0, 0.6]),
        },
        "body": {"theory": "solid", "degree": chance.choice([1, 2])},
        "clamp": {"facets": "left"},
        "contact": contact,
    }


def _named(model: str, length: float) -> Section:
    return {"model": model, "length_unit": "m", "length": length}


def _matrices(chance: Random, folder: Path) -> dict[str, Section]:
    K, M = chance.choice([_chain, _chain, _dense])(chance)
    count = chance.randint(1, min(4, len(K)))
    places = sorted(chance.sample(range(len(K)), count))
    B = np.zeros((count, len(K)))
    B[range(count), places] = [chance.choice([1.0, 1.0, -1.0]) for _ in places]
    np.savez(folder / "structure.npz", K=K, M=M, B=B)
    gap = _spread(chance, 1e-6, 1.0)
    gaps = [gap * chance.uniform(0.7, 1.5) for _ in places]
    return {
        "matrices": {"file": "structure.npz"},
        "contact": {"gap": chance.choice([gap, gaps])},
    }


def _chain(chance: Random) -> tuple[np.ndarray, np.ndarray]:
    """Masses in a row, between walls or with a free end; one may be zero."""
    size, stiffest = chance.randint(2, 30), _spread(chance, 1e2, 1e8)
    k = np.array([stiffest * _spread(chance, 1e-2, 1.0) for _ in range(size + 1)])
    k[-1] *= chance.random() < 0.5
    m = np.array([_spread(chance, 1e-2, 1.0) for _ in range(size)])
    if size > 4 and chance.random() < 0.3:
        m[chance.randrange(1, size)] = 0.0
    K = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    return K, np.diag(m)


def _dense(chance: Random) -> tuple[np.ndarray, np.ndarray]:
    """Symmetric positive definite matrices without structure."""
    size, rng = chance.randint(2, 16), np.random.default_rng(chance.randrange(2**32))
    one, other = rng.normal(size=(2, size, size))
    scale = _spread(chance, 1e2, 1e8)
    return scale * (one @ one.T + np.eye(size)), 0.1 * other @ other.T + np.eye(size)


def _reduction(chance: Random, *, of_mesh: bool) -> Section:
    methods = ["massless", "craig-bampton", "none"] if of_mesh else ["massless", "craig-bampton"]
    weights = [0.7, 0.15, 0.15][: len(methods)]
    (method,) = chance.choices(methods, weights)
    section: Section = {"method": method, "modes": chance.choice([1, 2, 3, 4, 5, 6, 8, 10, 15, 20])}
    if of_mesh and method == "craig-bampton":
        section["interface"] = chance.choice(["all", "contact"])
    return section


def _mode(chance: Random) -> Section:
    harmonics = chance.choice([1, 2, 3, 4, 5, 6, 8, 10, 12, 15])
    samples = chance.choice([2 * harmonics + 1, 3 * harmonics + 1, 4 * harmonics, 64, 128])
    return {
        "number": chance.choice([1, 1, 1, 2, 3]),
        "harmonics": harmonics,
        "samples": max(samples, 2 * harmonics + 1),
        "series": chance.choice(["time-reversible"] * 3 + ["general"]),
    }


def _press(chance: Random, contact: Section, continuation: Section) -> None:
    """Make some gaps zero or negative, one in four studies each; else the study stays as it is."""
    kind, gap = chance.random(), contact["gap"]
    frequencies = continuation.get("frequencies")
    if kind < 0.25 and frequencies:
        ends = frequencies["to"], frequencies["from"]
        frequencies["from"], frequencies["to"] = (2.0 - end for end in ends)
    if kind < 0.25 and isinstance(gap, list):
        contact["gap"] = [chance.choice([-1.0, 1.0]) * each for each in gap]
    elif kind < 0.25:
        contact["gap"] = -gap
    elif kind < 0.5 and not isinstance(gap, list):
        contact |= {"gap": 0.0, "reference_displacement": gap}


def _continuation(chance: Random, *, with_mass: bool) -> Section:
    first, last = chance.choice([0.7, 0.95, 1.0, 1.02]), chance.uniform(1.2, 3.0)
    step = chance.choice([0.1, 0.2, 0.3, 0.5])
    ways = ["energy"] * 4 + ["frequency", "arc-length", "follow"]
    way = "energy" if with_mass else chance.choice(ways)
    if way == "frequency":
        frequencies = {"from": 1.0 + 0.02 * chance.random(), "to": 1.02 + 0.1 * chance.random()}
        return {"parameter": way, "frequencies": {**frequencies, "step": 0.05 * step}}
    section: Section = {"energies": {"from": first, "to": last, "step": step}}
    if chance.random() < 0.3:
        section["report_at"] = [chance.uniform(first, last)]
    if way in ("arc-length", "follow"):
        section["arc_length"] = {"points": chance.choice([30, 60])}
    if way == "arc-length":
        section["parameter"] = way
        del section["energies"]["step"]
    if way == "follow":
        section["internal_resonance"] = way
    return section


def _spread(chance: Random, low: float, high: float) -> float:
    """A number spread evenly over the orders of magnitude."""
    return math.exp(chance.uniform(math.log(low), math.log(high)))


def main() -> int:
    """Run studies one after the other; 0 if none ended as it must not."""
    parser = argparse.ArgumentParser(description="run random studies and judge how they end")
    parser.add_argument("--count", type=int, default=WHOLE, help="how many studies")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--seconds", type=float, default=600.0, help="longest time of a study")
    parser.add_argument("--folder", type=Path, help="where studies and results are kept")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch, Examiner(chosen.seconds) as examiner:
        outcomes = []
        for number in range(chosen.first, chosen.first + chosen.count):
            study = write_study(number, (chosen.folder or Path(scratch)) / f"{number:03d}")
            outcomes.append(examiner.outcome(study))
            _say(f"{number:4d}  {outcomes[-1]}")
    _summarise(outcomes, whole=(chosen.first, chosen.count) == (0, WHOLE))
    return 1 if any(outcome.faulty for outcome in outcomes) else 0


def _summarise(outcomes: list[Outcome], *, whole: bool) -> None:
    _say("\ndocs: random_studies" if whole else "")
    _say("| end of the study | studies | status of the point | points |\n|---|---|---|---|")
    statuses: Counter[str] = sum((outcome.statuses for outcome in outcomes), Counter())
    checked = sum(outcome.checked for outcome in outcomes)
    shot = sum(outcome.shot for outcome in outcomes)
    more = {
        VERIFIED: f"; independent integration in time for {checked} of these points, "
        f"also independent shooting for {shot} of the {checked}"
    }
    points = [
        f"`{status}` | {count}{more.get(status, '')}" for status, count in statuses.most_common()
    ]
    ends = Counter(outcome.end for outcome in outcomes).most_common()
    studies = [f"{end} | {count}" for end, count in ends]
    if not any(outcome.faulty for outcome in outcomes):
        studies.append("no end, crash or wrong number | 0")
    for left, right in zip_longest(studies, points, fillvalue=" | "):
        _say(f"| {left} | {right} |")
    _say(f"\nlongest study: {max(o.seconds for o in outcomes):.1f} s")


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
