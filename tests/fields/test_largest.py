"""Places of largest values: the lowest of equal nodes, of values of any sign."""

import numpy as np
import pytest

from fenics_nnm.fields.largest import first_of_largest


@pytest.mark.parametrize(
    ("values", "place"),
    [
        ([1.0, 3.0, 2.0], 1),
        ([-3.0, -1.0, -2.0], 1),
        ([2.0, 1.0, 2.0 * (1 + 1e-12)], 2),  # equal but for round-off: node 5 before node 9
        ([-2.0, -3.0, -2.0 * (1 + 1e-12)], 2),
        ([0.0, 0.0, 0.0], 2),
        ([np.nan, np.nan, np.nan], 0),
    ],
)
def test_the_lowest_of_equal_nodes_is_taken(values: list[float], place: int) -> None:
    assert first_of_largest(np.array(values), np.array([9, 7, 5])) == place
