"""Imports without a search for cycles: what it leaves on and off afterwards."""

from __future__ import annotations

import gc

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
