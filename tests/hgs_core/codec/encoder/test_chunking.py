"""Which splats share a chunk: every splat is in one, and those of like grade, size and life are together."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.codec.encoder import chunking as layers
from hgs_core.codec.encoder.chunking import Layer, dynamic_layers, slice_limits, static_layers
from hgs_core.codec.encoder.encode_dynamic import SegmentTime
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from tests.hgs_core.codec.encoder.prepared import prepared

SETTINGS = EncodeSettings(static_chunk_splats=6, dynamic_chunk_splats=6, small_chunk_splats=3, slice_seconds=0.5)
TIME = SegmentTime(2.0, 4.0, 1.0)
QUARTERS = np.linspace(0, 1, 5)


def members(found: list[Layer]) -> list[list[int]]:
    return [sorted(layer.index.tolist()) for layer in found]


def test_grades_have_chunks_of_their_own_and_those_that_show_most_come_first() -> None:
    utility = np.array([1.0, 16.0, 1 / 16] * 4)
    found = static_layers(prepared(12, utility=utility), SETTINGS)
    assert members(found) == [[1, 4, 7, 10], [0, 3, 6, 9], [2, 5, 8, 11]]
    assert [layer.utility for layer in found] == [16.0, 1.0, 1 / 16]


@pytest.mark.parametrize(
    ("counts", "chunks"),
    [((2, 3, 3), [[0, 1, 2, 3, 4], [5, 6, 7]]), ((3, 2, 0), [[0, 1, 2, 3, 4]]), ((1, 1, 0), [[0, 1]])],
)
def test_a_grade_of_few_splats_joins_the_next_lower_one_and_the_last_the_one_above(
    counts: tuple[int, ...], chunks: list[list[int]]
) -> None:
    utility = np.repeat([16.0, 1.0, 1 / 16], counts)
    assert members(static_layers(prepared(len(utility), utility=utility), SETTINGS)) == chunks


def test_no_chunk_is_larger_than_it_may_be_and_large_groups_are_cut_evenly() -> None:
    found = static_layers(prepared(13), SETTINGS)
    assert sorted(map(len, members(found))) == [4, 4, 5]
    assert sorted(n for part in members(found) for n in part) == list(range(13))


def test_large_groups_are_cut_by_what_their_splats_show() -> None:
    utility = 1 + np.array([3, 11, 0, 8, 5, 10, 1, 7, 2, 9, 4, 6]) / 100  # one grade
    assert members(static_layers(prepared(12, utility=utility), SETTINGS)) == [[1, 3, 5, 7, 9, 11], [0, 2, 4, 6, 8, 10]]


@pytest.mark.parametrize(("huge", "chunks"), [(3, 2), (2, 1)])
def test_splats_with_far_wider_steps_of_place_go_apart_unless_they_are_few(huge: int, chunks: int) -> None:
    size = np.where(np.arange(9) < huge, 0.0, np.log(0.01))[:, None]  # a hundred times as large
    settings = EncodeSettings(small_chunk_splats=3, largest_position_step=100.0)
    # Far from the origin the finer grid could not be held in floats, so that even few would be taken apart.
    found = static_layers(prepared(9, log_scale=size + np.zeros((1, 3)), position=1.0), settings)
    assert len(found) == chunks
    if chunks == 2:
        assert sorted(members(found)) == [list(range(huge)), list(range(huge, 9))]


def test_slices_are_equal_parts_of_the_time_shown_of_about_the_length_asked() -> None:
    seconds, normalised = slice_limits(SegmentTime(2.0, 3.8, 1.1), 3.98, SETTINGS)
    np.testing.assert_allclose(seconds, np.linspace(2.0, 3.98, 5))
    np.testing.assert_allclose(normalised, np.linspace(0.0, 1.1, 5))
    assert len(slice_limits(SegmentTime(2.0, 2.1, 1.0), 2.1, SETTINGS)[0]) == 2


def brief(centers: list[float], log_precision: float = 12.0) -> dict[str, object]:
    """Splats that live for about a hundredth of the segment around their centres."""
    return {"time_center": np.array(centers), "time_log_precision": log_precision}


def test_dynamics_are_in_the_first_slice_in_which_they_live() -> None:
    centers = [0.6, 0.1, 0.9, 0.1, 0.4] * 3
    found = dynamic_layers(prepared(15, **brief(centers)), TIME, QUARTERS, SETTINGS)
    by_slice = {layer.slice: sorted(layer.index.tolist()) for layer in found}
    assert by_slice == {0: [1, 3, 6, 8, 11, 13], 1: [4, 9, 14], 2: [0, 5, 10], 3: [2, 7, 12]}
    assert [layer.slice for layer in found] == sorted(layer.slice for layer in found)


def test_what_is_not_yet_born_or_dead_when_the_segment_is_shown_lies_in_its_ends() -> None:
    found = dynamic_layers(prepared(6, **brief([-0.5] * 3 + [1.5] * 3)), TIME, QUARTERS, SETTINGS)
    assert {layer.slice: sorted(layer.index.tolist()) for layer in found} == {0: [0, 1, 2], 3: [3, 4, 5]}


def test_within_a_slice_those_that_show_most_come_first() -> None:
    utility = np.array([1.0, 16.0, 1 / 16] * 4)
    found = dynamic_layers(prepared(12, utility=utility, **brief([0.1] * 12)), TIME, QUARTERS, SETTINGS)
    assert [layer.utility for layer in found] == [16.0, 1.0, 1 / 16]


@pytest.mark.parametrize(("least", "chunks"), [(4, [[0, 1, 2, 3], [4, 5, 6, 7]]), (5, [list(range(8))])])
def test_many_splats_that_live_on_have_chunks_apart_from_those_that_die(
    monkeypatch: pytest.MonkeyPatch, least: int, chunks: list[list[int]]
) -> None:
    monkeypatch.setattr(layers, "LONG_LIVED_SPLATS", least)
    lives = {"time_center": np.full(8, 0.1), "time_log_precision": np.array([12.0] * 4 + [-9.0] * 4)}
    settings = EncodeSettings(small_chunk_splats=3)
    found = dynamic_layers(prepared(8, **lives), TIME, QUARTERS, settings)
    assert members(found) == chunks


def test_no_splats_make_no_layers() -> None:
    assert dynamic_layers(prepared(0), TIME, QUARTERS, SETTINGS) == []
