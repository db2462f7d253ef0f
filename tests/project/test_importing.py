"""Imports: no search for cycles in between, and what a run does not import."""

from __future__ import annotations

import gc
import subprocess
import sys

import pytest

from fenics_nnm.importing import importing


@pytest.mark.parametrize("searched", [True, False])
def test_search_goes_on_as_before_and_leaves_out_what_was_there(searched: bool) -> None:
    before = gc.isenabled()
    try:
        gc.enable() if searched else gc.disable()
        with importing():
            assert not gc.isenabled()
        assert gc.isenabled() == searched
        assert gc.get_freeze_count() > 10_000
    finally:
        gc.unfreeze()
        gc.enable() if before else gc.disable()


def test_search_goes_on_after_an_import_that_fails() -> None:
    with pytest.raises(ModuleNotFoundError), importing():
        raise ModuleNotFoundError
    gc.unfreeze()
    assert gc.isenabled()


def test_a_run_that_shows_no_bars_imports_nothing_that_draws_them() -> None:
    asked = "import sys, fenics_nnm.run; print('rich' in sys.modules)"
    told = subprocess.run([sys.executable, "-c", asked], check=True, capture_output=True, text=True)
    assert told.stdout.split() == ["False"]
