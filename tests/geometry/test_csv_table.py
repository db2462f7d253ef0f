"""Tables as spreadsheets of different languages write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.csv_table import read_table


@pytest.mark.parametrize("separator", [",", ";", "\t", " ; "])
def test_cells_between_commas_semicolons_and_tabs(separator: str, tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    rows = (("r_mm", "name"), ("1.5", "tip, high" if ";" in separator else "tip"))
    path.write_bytes(b"\xef\xbb\xbf" + "\r\n".join(map(separator.join, rows)).encode())
    table = read_table(path, "file")
    assert table.column_with_unit("r") == "r_mm"
    assert table.rows[0].number("r_mm") == 1.5 and table.rows[0].text("name").startswith("tip")


def test_a_decimal_comma_is_told(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("r_mm;x_mm\n1,5;2\n")
    with pytest.raises(GeometryError, match='line 2: r_mm = "1,5": must be a number'):
        read_table(path, "file").rows[0].number("r_mm")
