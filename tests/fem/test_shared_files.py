"""Field files written by several ranks, part by part: the same whatever the ranks and parts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from conftest import BEAM, Ended, changed, contents
from ranks import SAME_FIELD, field_differences, on_ranks
from written_fields import arrays_of

import fenics_nnm.fields.files
from fenics_nnm.fields.frames import Frames
from fenics_nnm.fields.parts import compact_parts
from fenics_nnm.fields.table import PartTable
from fenics_nnm.results.stored_branch import read_stored_branch

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: A beam of 153 nodes, with a motion that has everything that can be written.
SMALL = changed(BEAM, {"mesh": {"elements": [4, 1, 2]}, "contact": {"points": 3}})

#: Exports with parts of few nodes; one rank may fail in the middle.
EXPORTING = """
import sys
from mpi4py import MPI
import fenics_nnm.fields.files as files
from fenics_nnm.cli import main

files.NODES_OF_PART = {nodes}
done, kept = 0, files.MotionFiles.keep_stresses

def keep(self, part, used, motions):
    global done
    done += 1
    if MPI.COMM_WORLD.rank == {failing} and done == 2:
        raise {error}
    kept(self, part, used, motions)

files.MotionFiles.keep_stresses = keep
code = main(sys.argv[1:])
told = MPI.COMM_WORLD.gather(done)
if told and not code:
    print("parts", told)
sys.exit(code)
"""


def exporting(folder: Path, *, nodes: int, failing: int = -1, error: str = "None") -> Path:
    script = folder / "exporting.py"
    script.write_text(EXPORTING.format(nodes=nodes, failing=failing, error=error))
    return script


@pytest.mark.parametrize("method", ["massless", "none"])
def test_files_do_not_depend_on_the_ranks(
    method: str, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """To the last byte, as all that is computed together is the same."""
    study = study_file(SMALL, reduction={"method": method, "modes": 3})
    assert command("run", study, "--output", "out").code == 0
    script = exporting(tmp_path, nodes=25)
    found = {}
    for ranks in (1, 2, 3):
        asked = ("export", "out", "--gamma", "1.1", "--output", f"by{ranks}")
        ended = on_ranks(ranks, script, *asked, folder=tmp_path)
        assert ended.code == 0, ended.err
        parts = ended.out.splitlines()[-1]
        assert parts == {1: "parts [8]", 2: "parts [4, 4]", 3: "parts [3, 3, 2]"}[ranks]
        found[ranks] = contents(tmp_path / f"by{ranks}")
    assert len(found[1]) == 2 * 24 + 5  # frames, their lists, peaks, shapes and the view
    assert found[1] == found[2] == found[3]
    (tmp_path / "out/fields/linear_modes.vtu").unlink()
    apart = field_differences(tmp_path / "out/fields", tmp_path / "by1")
    assert max(apart.values()) <= SAME_FIELD, apart


@pytest.mark.parametrize("rank", [0, 1])
def test_error_of_one_rank_is_told_once(
    rank: int, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    assert command("run", study_file(SMALL), "--output", "out").code == 0
    error = 'OSError(28, "No space left on device", "frame")'
    script = exporting(tmp_path, nodes=25, failing=rank, error=error)
    ended = on_ranks(2, script, "export", "out", "--gamma", "1.1", folder=tmp_path, seconds=60)
    assert ended.code == 1, ended.err
    (line,) = [line for line in ended.err.splitlines() if "fenics-nnm: " in line]
    assert "out/export: cannot be written: No space left on device" in line and "rank" not in line
    assert not (tmp_path / "out/export").exists()


def test_parts_are_small_and_have_every_place_once() -> None:
    places = np.random.default_rng(2).uniform(size=(1000, 3)) * [10.0, 1.0, 0.1]
    parts = compact_parts(places, 130)
    assert [len(part) for part in parts] == [125] * 8
    assert np.array_equal(np.sort(np.concatenate(parts)), np.arange(1000))
    assert all(np.ptp(places[part, 0]) < 10 / 6 for part in parts)  # across the longest extent


def test_no_more_than_a_part_has_stresses_at_once(
    study_file: StudyFile, command: Command, monkeypatch: Any
) -> None:
    assert command("run", study_file(SMALL), "--output", "out").code == 0
    sizes, made = [], fenics_nnm.fields.motion.stress_basis

    def noted(*arguments: Any) -> Any:
        basis = made(*arguments)
        sizes.append(basis.stresses.nbytes)
        return basis

    monkeypatch.setattr(fenics_nnm.fields.files, "NODES_OF_PART", 40)
    monkeypatch.setattr(fenics_nnm.fields.motion, "stress_basis", noted)
    assert command("export", "out", "--gamma", "1.1").code == 0
    branch = read_stored_branch(Path("out/branch.h5"))
    shapes = len(branch.shapes) + len(branch.residual_shapes)
    assert len(sizes) == 4 and max(sizes) <= 8 * shapes * 6 * 40
    assert sum(sizes) == 8 * shapes * 6 * len(branch.nodes)


@pytest.mark.parametrize(
    ("fields", "arrays"),
    [
        ("displacement", {"displacement (m)"}),
        ("velocity,stress", {"velocity (m/s)", "stress (Pa)"}),
        ("gap,peak_stress", set()),
    ],
)
def test_fields_that_are_not_wanted_are_left_out(
    fields: str, arrays: set[str], study_file: StudyFile, command: Command
) -> None:
    assert command("run", study_file(SMALL), "--output", "out").code == 0
    assert command("export", "out", "--gamma", "1.1", "--fields", fields).code == 0
    frame = Path("out/export/motion_1.1/frame_0005.vtu")
    assert frame.exists() == bool(arrays)
    assert not arrays or set(arrays_of(frame)) == {"Points", *arrays}
    names = {path.name for path in Path("out/export").iterdir()}
    assert ("peak_stress_1.1.vtu" in names) == ("peak" in fields)
    assert ("motion_1.1_contact.pvd" in names) == ("gap" in fields)


def test_frames_of_a_reversible_motion_are_shown_twice() -> None:
    for count in (24, 25):
        frames = Frames(count, reversible=True)
        shown = [frames.shown_by(number) for number in range(frames.distinct)]
        assert sorted(frame for each in shown for frame in each) == list(range(count))
        for number, each in enumerate(shown):
            for frame, sign in each.items():
                assert np.cos(2 * np.pi * frame / count) == pytest.approx(
                    np.cos(2 * np.pi * frames.times[number])
                )
                assert np.sin(2 * np.pi * frame / count) == pytest.approx(
                    sign * np.sin(2 * np.pi * frames.times[number]), abs=1e-12
                )
        times, places = frames.searched()
        assert np.array_equal(times[places], frames.times) and times.max() <= 0.5
    assert Frames(24, reversible=False).distinct == 24


def test_table_gives_back_rows_of_all_parts(tmp_path: Path) -> None:
    values = np.random.default_rng(5).standard_normal((7, 20))
    parts = [np.array([0, 3, 19]), np.arange(4, 19), np.array([1, 2])]
    table = PartTable(tmp_path / "table", parts, 7)
    table.make()
    for part in (2, 0, 1):
        for first in (5, 0):
            rows = slice(first, 7 if first else 5)
            table.put(part, first, values[rows, parts[part]])
    assert np.array_equal(table.read(slice(3, 6)), values[3:6])
    assert table.path.stat().st_size == values.nbytes


def test_shapes_in_pieces_are_read_too(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """As h5repack leaves them; those of a run are mapped where they are."""
    assert command("run", study_file(SMALL), "--output", "out").code == 0
    file = tmp_path / "out/branch.h5"
    before = read_stored_branch(file)
    assert not before.shapes.flags.owndata and not before.shapes.flags.writeable
    shapes = np.array(before.shapes)
    with h5py.File(file, "r+") as opened:
        del opened["basis/shapes"]
        opened.create_dataset("basis/shapes", data=shapes, chunks=True, compression="gzip")
    np.testing.assert_array_equal(read_stored_branch(file).shapes, shapes)
