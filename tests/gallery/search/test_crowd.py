"""Products from the stacked sketches are those of each person's own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.testing import assert_allclose

from harmonicface.gallery.search.crowd import crowd
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import sketch


def test_products_of_one_and_of_several_photographs(draw: Callable[..., Any]) -> None:
    rng = np.random.default_rng(0)
    rows = draw(rng, [2, 5, 2, 5, 5], 40, 0.3)
    basis = SharedBasis(np.linalg.qr(rng.normal(size=(40, 12)))[0].T)
    sketches = [sketch(one, basis, (4, 12)) for one in rows]
    units = rng.normal(size=(40, 3))
    coordinates = (basis.rows @ units).astype(np.float32)
    companies = crowd(sketches, (4, 12))
    assert [company.people.tolist() for company in companies] == [[0, 2], [1, 3, 4]]
    for company in companies:
        everybody = np.arange(len(company.people))
        first = company.first_products(coordinates)
        second = company.next_products(1, everybody, first, coordinates)
        alone = company.first_products(coordinates[:, 1])
        assert_allclose(first[:, :, 1], alone, atol=1e-6)
        assert_allclose(company.first_products(coordinates, everybody[1:]), first[1:], atol=1e-6)
        assert_allclose(second[:, :, 1], company.next_products(1, everybody, alone, coordinates[:, 1]), atol=1e-6)
        for place, who in enumerate(company.people):
            shared = rows[who].astype(np.float64) @ basis.rows.T @ (basis.rows @ units)
            assert_allclose(np.linalg.norm(second[place], axis=0), np.linalg.norm(shared, axis=0), atol=1e-5)
