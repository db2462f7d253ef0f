"""The folder of caches: damage, wrong keys, too much, and folders of others."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Ended

from fenics_nnm.files import cache as cache_module
from fenics_nnm.files.cache import VARIABLE, Cache, cache_of_user, key_of

ARRAYS = {"shapes": np.asfortranarray(np.arange(6.0).reshape(2, 3)), "count": np.int64(3)}


@pytest.fixture
def cache(tmp_path: Path) -> Cache:
    return Cache(tmp_path / "kept")


def test_arrays_come_back_bit_for_bit_and_in_their_order(cache: Cache) -> None:
    cache.write("a", ARRAYS)
    found = cache.read("a")
    assert found is not None
    assert found["shapes"].flags.f_contiguous  # sums of a product depend on it
    assert found["shapes"].tobytes("A") == ARRAYS["shapes"].tobytes("A")
    assert int(found["count"]) == 3
    assert cache.read("b") is None


@pytest.mark.parametrize("place", [0, 25, -1])
def test_a_damaged_file_counts_as_none_and_is_removed(cache: Cache, place: int) -> None:
    cache.write("a", ARRAYS)
    (path,) = cache.files()
    data = bytearray(path.read_bytes())
    data[place] ^= 1
    path.write_bytes(data)
    assert cache.read("a") is None
    assert cache.files() == []


def test_a_file_under_the_name_of_another_key_is_not_taken(cache: Cache) -> None:
    cache.write("a", ARRAYS)
    cache.files()[0].rename(cache.folder / "b.kept")
    assert cache.read("b") is None


def test_a_write_that_is_cut_short_leaves_what_was_there(
    cache: Cache, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache.write("a", ARRAYS)

    def full(*given: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    cache.write("a", {"shapes": np.zeros(3)})
    found = cache.read("a")
    assert found is not None
    assert found["shapes"].shape == (2, 3)
    assert [path.name for path in cache.folder.iterdir()] == ["a.kept"]


def test_what_was_not_needed_for_the_longest_time_goes_first(tmp_path: Path) -> None:
    size = 8 * 1000 + 400  # of an array of a thousand numbers, with its head
    cache = Cache(tmp_path, most=5 * size)
    for number, key in enumerate("abcd"):
        cache.write(key, {"x": np.arange(1000.0)})
        os.utime(tmp_path / f"{key}.kept", (number, number))
    assert cache.read("a") is not None  # and is the newest now
    cache.write("e", {"x": np.arange(2000.0), "too large": np.zeros(9000)})
    assert len(cache.files()) == 4
    for key in "ef":
        cache.write(key, {"x": np.arange(1000.0)})
    assert {path.stem for path in cache.files()} == set("acdef")
    assert cache.size() <= cache.most


def test_a_folder_that_others_can_write_to_keeps_nothing(cache: Cache) -> None:
    cache.folder.mkdir()
    cache.folder.chmod(0o777)
    cache.write("a", ARRAYS)
    assert list(cache.folder.iterdir()) == []
    cache.folder.chmod(0o700)
    cache.write("a", ARRAYS)
    cache.folder.chmod(0o777)
    assert cache.read("a") is None  # whoever has put it there


def test_what_killed_commands_left_goes_in_time(cache: Cache) -> None:
    cache.folder.mkdir()
    old, new = cache.folder / "old.part", cache.folder / "new.part"
    for path in (old, new):
        path.write_bytes(b"half of it")
    os.utime(old, (1, 1))
    cache.write("a", ARRAYS)
    assert not old.exists() and new.exists()  # another command may be writing it
    assert cache.clear() == 1
    assert list(cache.folder.iterdir()) == []


def test_parts_of_a_key_do_not_run_into_each_other() -> None:
    assert key_of("ab", "c") != key_of("a", "bc") != key_of("abc")
    assert key_of("a", b"b") == key_of(b"a", "b")


def test_the_environment_says_where(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cache_of_user() is None  # in all tests
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    assert cache_of_user() == Cache(tmp_path)
    monkeypatch.setenv(VARIABLE, "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_of_user() == Cache(tmp_path / "fenics-nnm")
    cache_module.turn_off()
    assert cache_of_user() is None


def test_a_relative_folder_is_refused_and_the_home_folder_known(
    command: Callable[..., Ended], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "me"))
    monkeypatch.setenv(VARIABLE, "~/kept")
    assert cache_of_user() == Cache(tmp_path / "me" / "kept")
    for named in ("kept", "./kept", "~nobody-of-this-name/kept"):
        monkeypatch.setenv(VARIABLE, named)
        command("cache").assert_one_line(2, f"{VARIABLE} = {named}: must be an absolute path")


def test_the_command_shows_and_empties_it(
    command: Callable[..., Ended], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "is off" in command("cache").out
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kept"))
    cache = Cache(tmp_path / "kept")
    cache.write("a", ARRAYS)
    assert "1 files" in command("cache").out
    assert "1 files removed" in command("cache", "--clear").out
    assert cache.files() == []
