"""Folders of caches where home or the folder for temporary files cannot be written to."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest

from fenics_nnm.errors import OutputError
from fenics_nnm.files.caches import use_writable_caches

NAMES = ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR", "TMPDIR")


@pytest.fixture
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for temporary files in place of /tmp, and none of the variables set but HOME."""
    for name in NAMES:
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    return tmp_path


def variables() -> dict[str, str]:
    return {name: os.environ[name] for name in NAMES if name in os.environ}


def test_a_home_that_can_be_written_is_used(scratch: Path) -> None:
    before = variables()
    use_writable_caches()
    assert variables() == before
    assert not (scratch / f"fenics-nnm-{os.getuid()}").exists()


def test_relative_folders_count_as_none(scratch: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They would be others for each command, in folders of studies."""
    monkeypatch.chdir(scratch)
    before = variables()
    monkeypatch.setenv("XDG_CACHE_HOME", "kept")
    monkeypatch.setenv("XDG_CONFIG_HOME", "./kept")
    use_writable_caches()
    assert variables() == before
    assert not (scratch / "kept").exists()


@pytest.mark.parametrize("home", ["/proc", "/dev/null", "/proc/none/below"])
def test_a_home_that_cannot_be_is_replaced(
    scratch: Path, monkeypatch: pytest.MonkeyPatch, home: str
) -> None:
    monkeypatch.setenv("HOME", home)
    monkeypatch.setenv("MPLCONFIGDIR", "/proc/none")
    use_writable_caches()
    own = scratch / f"fenics-nnm-{os.getuid()}"
    assert own.stat().st_mode & 0o777 == 0o700
    assert variables() == {
        "HOME": str(own),
        "XDG_CACHE_HOME": str(own / ".cache"),
        "XDG_CONFIG_HOME": str(own / ".config"),
    }
    again = variables()
    use_writable_caches()
    assert variables() == again


def test_a_folder_that_others_can_write_to_is_not_taken(
    scratch: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compiled code is loaded from there: it must be of this user alone."""
    own = scratch / f"fenics-nnm-{os.getuid()}"
    own.mkdir()
    own.chmod(0o777)
    monkeypatch.setenv("HOME", "/proc")
    use_writable_caches()
    assert Path(os.environ["HOME"]) != own
    assert Path(os.environ["HOME"]).parent == scratch


def test_no_place_for_temporary_files_is_one_line(
    scratch: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none() -> str:
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr(tempfile, "gettempdir", none)
    with pytest.raises(OutputError, match=r"must have space in /tmp, or .* TMPDIR"):
        use_writable_caches()
