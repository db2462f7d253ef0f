"""Warnings that may mean a wrong number are shown in a line; those for programmers are not."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.integrate import IntegrationWarning, quad
from scipy.sparse import SparseEfficiencyWarning
from scipy.sparse.linalg import MatrixRankWarning

from fenics_nnm.commands.shared import complain
from fenics_nnm.commands.warnings_shown import of_numbers, show_by_line


@pytest.fixture(autouse=True)
def shown() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        show_by_line()
        yield


def test_an_overflow_and_a_poor_integral_are_a_line_each(caplog: Any) -> None:
    assert np.isinf(np.array([1e200]) * np.array([1e200]))
    quad(lambda x: 1 / x, 0, 1)
    lines = [record.getMessage() for record in caplog.records]
    assert lines[0].startswith("overflow encountered in multiply (commands/test_warnings_shown.py")
    assert lines[0].endswith("numbers may be wrong")
    assert len(lines) >= 2 and not any("\n" in line for line in lines)


def test_what_is_said_to_programmers_is_not_shown(caplog: Any) -> None:
    warnings.warn("old name", DeprecationWarning, stacklevel=1)
    warnings.warn("Glyph 9 missing", UserWarning, stacklevel=1)
    assert not [record for record in caplog.records if record.levelname == "WARNING"]


def test_kinds_of_warnings() -> None:
    assert all(map(of_numbers, (RuntimeWarning, MatrixRankWarning, IntegrationWarning)))
    assert not any(map(of_numbers, (UserWarning, FutureWarning, SparseEfficiencyWarning)))


def test_lines_show_what_would_move_the_cursor_as_escapes(capsys: Any) -> None:
    complain("a\u202eb\x1b[2J\udc80\u00e9\n")
    assert capsys.readouterr().err == "fenics-nnm: a\\u202eb\\x1b[2J\\udc80\u00e9\\n\n"
