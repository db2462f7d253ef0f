"""Runs on several ranks, and how their results are compared."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
from conftest import Ended
from written_fields import read_grid

#: Columns of backbone.csv that are round-off.
ROUND_OFF = {"penetration_m", "virial_error", "shot_return_error"}

#: An array, and the difference of it and a similar one, which is as accurate as itself.
PEAK = "peak von Mises stress (Pa)"
DIFFERENCE = "peak von Mises stress above that of the linear mode (Pa)"

#: Fields agree within this part of the largest value of the array in all files of a run.
SAME_FIELD = 1e-8


def on_ranks(count: int, *arguments: object, folder: Path, seconds: float = 120) -> Ended:
    """Run python on some ranks; everything started is killed when the time is over."""
    command = ["mpirun", "-n", str(count), "--oversubscribe", sys.executable, *map(str, arguments)]
    process = subprocess.Popen(
        command,
        cwd=folder,
        env={
            **os.environ,
            "OMP_NUM_THREADS": "1",
            "OMPI_MCA_mpi_yield_when_idle": "1",
            "PYTHONSAFEPATH": "",  # set where a test has run a command, and scripts import others
        },
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        out, err = process.communicate(timeout=seconds)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    return Ended(process.returncode, out, err)


def rows(path: Path) -> list[dict[str, str]]:
    """Rows of backbone.csv without what is round-off."""
    table = csv.DictReader(path.read_text().splitlines())
    return [{k: v for k, v in row.items() if k not in ROUND_OFF} for row in table]


def row_differences(one: Path, two: Path) -> dict[str, tuple[str, str]]:
    """Values of two tables that differ by more than the last of ten digits, by point and column."""
    found = {}
    for row, other in zip(rows(one), rows(two), strict=True):
        assert list(row) == list(other)
        for name, value in row.items():
            if value != other[name] and not _close(value, other[name]):
                found[f"{row['point']} {name}"] = (value, other[name])
    return found


def _close(one: str, two: str) -> bool:
    try:
        return abs(float(one) - float(two)) <= 1e-9 * abs(float(one))
    except ValueError:
        return False


def field_differences(one: Path, two: Path) -> dict[str, float]:
    """Largest difference of each array of all .vtu files, as a part of its largest value.

    Cells must be the same and nodes in their places: no file tells how many ranks wrote it.
    """
    names = sorted(path.relative_to(one) for path in one.rglob("*.vtu"))
    assert names == sorted(path.relative_to(two) for path in two.rglob("*.vtu"))
    largest: Counter[str] = Counter()
    difference: Counter[str] = Counter()
    for name in names:
        first, second = read_grid(one / name), read_grid(two / name)
        np.testing.assert_array_equal(first.cells, second.cells)
        np.testing.assert_allclose(second.points, first.points, rtol=0, atol=1e-12)
        assert list(first.point_data) == list(second.point_data)
        for array, values in first.point_data.items():
            if not array.startswith("phase of"):  # two instants may have the same stress
                largest[array] = max(largest[array], float(np.abs(values).max()))
                apart = float(np.abs(second.point_data[array] - values).max())
                difference[array] = max(difference[array], apart)
    if DIFFERENCE in largest:
        largest[DIFFERENCE] = max(largest[DIFFERENCE], largest[PEAK])
    return {array: difference[array] / (largest[array] or 1.0) for array in difference}


def own_lines(ended: Ended) -> list[str]:
    """Lines of the program among those of mpirun."""
    return [line for line in ended.err.splitlines() if "fenics-nnm: " in line]
