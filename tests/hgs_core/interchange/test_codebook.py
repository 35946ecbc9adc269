from __future__ import annotations

import numpy as np

from hgs_core.interchange.codebook import ENTRIES, codebook


def test_numbers_that_are_few_are_kept_as_they_are() -> None:
    values = np.float32([[3, -1], [0.25, -1]])
    table, numbers = codebook(values)
    assert table.shape == (ENTRIES,)
    assert (np.diff(table) >= 0).all()
    np.testing.assert_array_equal(table[numbers], values)


def test_a_table_is_better_than_equal_steps_and_each_number_has_its_nearest_entry() -> None:
    rng = np.random.default_rng(3)
    values = np.concatenate([rng.normal(0, 1, 5000), [80.0, -100.0]]).astype(np.float32)
    table, numbers = codebook(values)
    error = values - table[numbers]
    np.testing.assert_array_equal(np.abs(error), np.abs(values[:, None] - table).min(axis=1))
    steps = np.linspace(-100, 80, ENTRIES)
    plain = np.abs(values[:, None] - steps).min(axis=1)
    assert (error**2).mean() < (plain**2).mean() / 1000
    assert np.abs(error[-2:]).max() < 1  # outliers have entries of their own
