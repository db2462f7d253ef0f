"""Studies of all kinds on one rank and on two: frequencies, tables, fields and exports agree.

Run with `python3 tests/two_ranks.py`, or with names of studies; `make verify` runs all.
"""

from __future__ import annotations

import sys
import tempfile
import tomllib
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from conftest import BEAM, PLATE, changed, toml
from constrained_beams import joined
from fork_mesh import fork, fork_study
from ranks import SAME_FIELD, field_differences, on_ranks, rows

from fenics_nnm.results import branch_file

DEMOS = Path(__file__).parents[1] / "demos"

#: Frequencies, and other numbers of the table, agree within this part.
SAME_FREQUENCY = 1e-9

#: Fields of these agree less. The fork's first two modes are 1 % apart in frequency, so that
#: round-off of the assembly alone, whose order depends on the ranks, turns their shapes by 4e-8,
#: with the eigensolver's tolerance at 1e-10 as at 1e-12.
SAME_FIELD_OF = {"pads": 1e-7}

#: These errors are round-off below this.
ERRORS, ROUND_OFF_ERROR = {"error_remainder", "return_error_10"}, 1e-8

#: Lengths, in m, by which points miss their conditions; they are the same within this.
LENGTHS, SAME_LENGTH = {"tension_m"}, 1e-12

#: A run on two ranks that share a core takes minutes.
_SECONDS = 1800.0

#: A few energies, one of them with ParaView files.
ENERGIES = {"energies": {"from": 0.8, "to": 1.4, "step": 0.2}, "report_at": [1.4]}


def _demo(name: str, **changes: Any) -> dict[str, Any]:
    return changed(tomllib.loads((DEMOS / f"{name}.toml").read_text()), changes)


def rotor37(folder: Path) -> dict[str, Any]:
    """Blade of rotor 37 on a coarse mesh."""
    sections = str(DEMOS.parent / "meshes/rotor37_blade_sections.csv")
    return _demo(
        "rotor37/rotor37",
        mesh={"sections": sections, "element_size": 0.006},
        reduction={"modes": 20},
        continuation={"=": ENERGIES},
    )


def plate(folder: Path) -> dict[str, Any]:
    """Plate in plane stress."""
    return changed(PLATE, {"mesh": {"elements": [16, 4]}, "reduction": {"modes": 6}})


def pads(folder: Path) -> dict[str, Any]:
    """Tuning fork of two materials, with contact between facing patches."""
    return _demo("fork/fork", continuation={"=": ENERGIES})


def patches(folder: Path) -> dict[str, Any]:
    """Tuning fork, with contact between the tines, and of one tine with a casing."""
    fork(folder / "fork.msh", right=9)
    stop = {
        "name": "stop",
        "facets": "right tine",
        "direction": [0.0, 1.0],
        "points": 2,
        "rows": "averaged",
        "casing": {"shape": "cylinder", "axis": "z", "radius": 0.2},
    }
    tines = {"name": "tines", "facets": "left tine", "against": "right tine"}
    study = fork_study(folder / "fork.msh", patch=[tines, stop])
    return changed(study, {"reduction": {"modes": 5}, "continuation": {"=": ENERGIES}})


def interference(folder: Path) -> dict[str, Any]:
    """Beam that presses its obstacle at rest."""
    changes = {
        "mesh": {"elements": [6, 2, 2]},
        "contact": {"gap": -1e-4},
        "reduction": {"modes": 8},
        "continuation": {"=": ENERGIES},
    }
    return changed(BEAM, changes)


def coupled(folder: Path) -> dict[str, Any]:
    """Beam from an .inp file, with its end coupled to a node with a mass, on both ranks."""
    (folder / "joined.inp").write_text(joined("*COUPLING, *KINEMATIC with *MASS"))
    return changed(
        BEAM,
        {
            "mesh": {"=": {"file": "joined.inp", "length_unit": "m"}},
            "clamp": {"facets": "held"},
            "groups": {"=": {"pad": {"box": {"from": [0.09, -1.0, 0.0099], "to": [0.16, 1, 1]}}}},
            "contact": {"facets": "pad", "points": 4},
            "reduction": {"modes": 4},
        },
    )


STUDIES: dict[str, Callable[[Path], dict[str, Any]]] = {
    study.__name__: study for study in (plate, interference, pads, patches, coupled, rotor37)
}


def compare(name: str, folder: Path) -> None:
    """Run a study, and an export of it, on one rank and on two, and tell how they differ.

    Raises:
        AssertionError: if they differ by more than they may.
    """
    study = folder / "study.toml"
    study.write_text(toml(STUDIES[name](folder)))
    for ranks, output in ((1, "one"), (2, "two")):
        _run(ranks, folder, "run", study, "--output", output)
        _run(ranks, folder, "export", output, "--gamma", 1.0, "--output", f"{output}/export")
    one, two = folder / "one", folder / "two"
    frequencies = [
        [point.motion.frequency for point in branch_file.read(path / "branch.h5")[1]]
        for path in (one, two)
    ]
    apart = max(abs(b / a - 1) for a, b in zip(*frequencies, strict=True))
    table, other = (rows(path / "backbone.csv") for path in (one, two))
    cells = [
        f"{key} = {a[key]} and {b[key]}"
        for a, b in zip(table, other, strict=True)
        for key in a
        if not _same(key, a[key], b[key])
    ]
    fields = field_differences(one, two)
    largest = max(fields, key=lambda array: fields[array])
    title = STUDIES[name].__doc__ or name
    _say(
        f"| {title.rstrip('.')} | {len(table)} | {apart:.1e} | {len(cells)} "
        f"| {fields[largest]:.1e}, {largest} |"
    )
    assert apart <= SAME_FREQUENCY, frequencies
    assert not cells, cells
    assert fields[largest] <= SAME_FIELD_OF.get(name, SAME_FIELD), fields


def _same(key: str, one: str, two: str) -> bool:
    """Whether cells agree; numbers may be a unit of their last digit or `SAME_FREQUENCY` apart."""
    if one == two:
        return True
    try:
        a, b = Decimal(one), Decimal(two)
    except InvalidOperation:
        return False
    largest = max(abs(a), abs(b))
    last = Decimal(1).scaleb(min(int(x.as_tuple().exponent) for x in (a, b)))
    allowed = max(last, Decimal(SAME_FREQUENCY) * largest)
    if key in LENGTHS:
        allowed = max(allowed, Decimal(SAME_LENGTH))
    return abs(a - b) <= allowed or (key in ERRORS and largest < ROUND_OFF_ERROR)


def _run(ranks: int, folder: Path, *arguments: object) -> None:
    ended = on_ranks(ranks, "-m", "fenics_nnm", *arguments, folder=folder, seconds=_SECONDS)
    assert ended.code == 0, ended.err


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main(names: list[str]) -> None:
    """Compare all studies, or those named, and print a row of a table for each."""
    _say("" if names else "docs: two_ranks")
    _say(
        "| study | points | largest relative difference of a frequency "
        "| cells of backbone.csv that differ | largest difference of a field, and this field |"
    )
    _say("|---|---|---|---|---|")
    for name in names or STUDIES:
        with tempfile.TemporaryDirectory() as folder:
            compare(name, Path(folder))
    _say("")


if __name__ == "__main__":
    main(sys.argv[1:])
