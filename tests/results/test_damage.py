"""Results that are damaged, or not of this program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import pytest
from conftest import ROD, Ended, changed, toml

from fenics_nnm.errors import OutputError
from fenics_nnm.files import bounds
from fenics_nnm.results import branch_file

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

FEW = {"continuation": {"energies": {"from": 0.9, "to": 1.1, "step": 0.1}}}


@pytest.fixture(name="branch", scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from fenics_nnm.run import run_study
    from fenics_nnm.study import study_from

    folder = tmp_path_factory.mktemp("finished")
    values = changed(ROD, FEW)
    run_study(study_from(values, folder / "s.toml"), toml(values), folder / "r")
    return folder / "r" / "branch.h5"


def refused(path: Path, data: bytes) -> str:
    path.write_bytes(data)
    with pytest.raises(OutputError) as error:
        branch_file.read(path)
    message = str(error.value)
    assert message.startswith(f"{path}: ")
    return message


def test_every_flipped_byte_is_found(branch: Path, tmp_path: Path) -> None:
    data = branch.read_bytes()
    for place in range(0, len(data) - 100, len(data) // 40):
        bad = bytearray(data)
        bad[place] ^= 0x10
        assert "is damaged" in refused(tmp_path / "branch.h5", bytes(bad))


def test_a_file_cut_short_or_without_its_digest(branch: Path, tmp_path: Path) -> None:
    """Files of older versions have none."""
    data = branch.read_bytes()
    for length in range(0, len(data) // 2, len(data) // 8):
        refused(tmp_path / "branch.h5", data[:length])
    mark = data.rindex(b"fenics_nnm digest ")
    (tmp_path / "branch.h5").write_bytes(data[:mark])
    header, points = branch_file.read(tmp_path / "branch.h5")
    assert len(points) == 3 and header.mode == 1


def test_a_point_without_its_arrays_is_named(branch: Path, tmp_path: Path) -> None:
    path = tmp_path / "branch.h5"
    path.write_bytes(branch.read_bytes())
    with h5py.File(path, "r+") as file:
        del file["points/000001/q"]
    with pytest.raises(OutputError, match="is damaged, or was written by another program"):
        branch_file.read(path)


def test_results_of_links_are_refused(branch: Path, tmp_path: Path) -> None:
    path = tmp_path / "branch.h5"
    path.write_bytes(branch.read_bytes())
    with h5py.File(path, "r+") as file:
        del file["model/omega"]
        file["model/omega"] = h5py.ExternalLink(str(branch), "/model/omega")
    with pytest.raises(OutputError, match="/model/omega is a link to the file"):
        branch_file.read(path)


@pytest.mark.parametrize("packed", [True, False])
def test_small_files_of_huge_arrays_are_refused(branch: Path, tmp_path: Path, packed: bool) -> None:
    """An array without values, compressed or not, takes no place in the file."""
    data = branch.read_bytes()
    bad = tmp_path / "bad.h5"
    bad.write_bytes(data[: data.rindex(b"fenics_nnm digest ")])
    with h5py.File(bad, "r+") as file:
        del file["points/000000/q"]
        packing = {"chunks": (1, 100_000), "compression": "gzip"} if packed else {}
        file.create_dataset("points/000000/q", (60_000, 100_000), float, **packing)
    assert bad.stat().st_size < 2 * len(data)
    message = refused(bad, bad.read_bytes())
    assert "/points/000000/q would take 44.7 GiB: may take" in message


def test_arrays_as_large_as_their_place_in_the_file_need_not_fit(
    branch: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are mapped into memory."""
    monkeypatch.setattr(bounds, "free_memory", lambda: 10.0)
    assert len(branch_file.read(branch)[1]) == 3


def test_a_folder_with_the_study_is_no_output_folder(
    study_file: StudyFile, command: Command
) -> None:
    path = study_file(ROD, **FEW)
    (path.parent / "fields").mkdir()
    ended = command("run", path, "--output", path.parent)
    assert ended.code == 2 and f"holds {path.name}, which the study is read from" in ended.err
    assert (path.parent / "fields").is_dir() and not list(path.parent.glob(".running-*"))


def test_files_called_as_results_are_not_replaced(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    path, folder = study_file(ROD, **FEW), tmp_path / "mine"
    (folder / "pictures").mkdir(parents=True)
    (folder / "report.html").write_text("mine")
    ended = command("run", path, "--output", folder)
    assert ended.code == 2 and "has pictures, report.html that no run" in ended.err
    assert (folder / "report.html").read_text() == "mine"
