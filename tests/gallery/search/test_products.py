"""Products are those of a matrix product, with one photograph and with several, however the rows lie in memory."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.gallery.search.products import products


@pytest.mark.parametrize("count", [0, 1, 2, 5])
@pytest.mark.parametrize("shape", [(7, 30), (4, 9, 30), (0, 30)])
def test_products_are_exact_of_whole_numbers(count: int, shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    rows, photographs = rng.integers(-9, 10, shape), rng.integers(-9, 10, (30, count))
    found = products(rows.astype(np.float32), photographs.astype(np.float32))
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, np.tensordot(rows, photographs, 1))


def test_rows_may_lie_across() -> None:
    rng = np.random.default_rng(1)
    across, one = rng.normal(size=(30, 12)), rng.normal(size=(30, 1))
    np.testing.assert_allclose(products(across.T, one), across.T @ one, rtol=1e-12, atol=1e-12)
