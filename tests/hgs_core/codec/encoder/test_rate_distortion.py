from __future__ import annotations

import itertools

import numpy as np
import pytest

from hgs_core.codec.encoder.rate_distortion import EXCHANGE, choose, neighbours


def test_neighbours_are_all_within_a_step_of_the_nearest_which_comes_first() -> None:
    found = neighbours(np.array([[1.4, -2.6], [0.0, 7.0]]))
    assert found.shape == (2, 9, 2)
    assert found[:, 0].tolist() == [[1, -3], [0, 7]]
    assert sorted(map(tuple, found[0].tolist())) == sorted(itertools.product((0, 1, 2), (-4, -3, -2)))


def test_of_equally_near_numbers_the_common_one_is_taken() -> None:
    candidates = np.full((100, 2, 1), 5)
    candidates[0] = [[6], [5]]
    assert choose(candidates, np.zeros((100, 2)))[0].tolist() == [5]


@pytest.mark.parametrize(("share", "taken"), [(0.98, 0), (1.02, 1)])
def test_a_squared_error_is_weighed_against_the_bits_it_saves(share: float, taken: int) -> None:
    """Of 1023 zeros and a single 1 the 1 takes log2(1024.2 / 1.1) bits, each worth ln 4 / 12 of a squared step."""
    saved = np.log2(1024.2 / 1.1) - np.log2(1024.2 / 1023.1)
    candidates = np.zeros((1024, 2, 1), np.int64)
    candidates[0, 0] = 1
    cost = np.zeros((1024, 2))
    cost[0, 1] = share * np.log(4) / 12 * saved
    assert pytest.approx(np.log(4) / 12) == EXCHANGE
    assert choose(candidates, cost)[0].tolist() == [taken]


def test_of_a_chain_the_differences_are_what_takes_bits() -> None:
    rows = np.repeat(np.arange(100), 2).reshape(100, 1, 2)  # (0, 0), (1, 1), ...: differences of zero
    candidates = np.concatenate([rows, rows], axis=1)
    candidates[50, 0] = (50, 51)
    cost = np.zeros((100, 2))
    assert choose(candidates, cost, chain=True)[50].tolist() == [50, 50]
    assert choose(candidates, cost)[50].tolist() == [50, 51]


def test_what_cannot_be_taken_is_not() -> None:
    candidates = np.array([[[3], [4]]] * 3)
    assert choose(candidates, np.array([[np.inf, 9.0]] * 3)).tolist() == [[4]] * 3
