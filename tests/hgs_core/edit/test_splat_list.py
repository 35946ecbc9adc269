"""Lists of splats, and scenes without them."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.edit.splat_list import SplatList, drop_listed
from tests.hgs_core.edit.scenes import moving, splats

A, B, C = ("a" * 64, "b" * 64, "c" * 64)
STATIC = [(A, 100), (B, 20)]
SEGMENTS = [[(C, 60)], [("d" * 64, 60)]]


def load(folder: Path, document: Any) -> SplatList:
    file = folder / "list.json"
    file.write_text(json.dumps(document))
    return SplatList.load(file)


def listing(folder: Path, chunks: Any) -> SplatList:
    return load(folder, {"format": "hgs-splats", "version": 1, "chunks": chunks})


def test_exactly_the_listed_splats_go(tmp_path: Path) -> None:
    viewed = moving()
    listed = listing(tmp_path, {B: [[0, 1], [19, 19]], C: [[5, 7]]})
    edit = drop_listed(viewed, listed, STATIC, SEGMENTS)
    before, after = viewed.scene, edit.viewed.scene
    np.testing.assert_array_equal(after.static.means, np.delete(before.static.means, [100, 101, 119], axis=0))
    moved = [segment.dynamic.motion for segment in before.segments]
    np.testing.assert_array_equal(after.segments[0].dynamic.motion, np.delete(moved[0], [5, 6, 7], axis=0))
    np.testing.assert_array_equal(after.segments[1].dynamic.motion, moved[1])
    assert [str(change) for change in edit.changes] == [f"6 of {splats(viewed)} splats left out: list.json lists them"]


def test_a_chunk_of_another_scene_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=rf"chunks\.{A}: is not a chunk of this scene; give the scene in which"):
        drop_listed(moving(), listing(tmp_path, {A: [[0, 0]]}), [(B, 120)], SEGMENTS)


def test_a_splat_beyond_its_chunk_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=rf"chunks\.{B}: names splat 20 of 20, which count from 0"):
        drop_listed(moving(), listing(tmp_path, {B: [[3, 20]]}), STATIC, SEGMENTS)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"format": "hgs-scene"}, "format: is \"hgs-scene\", not 'hgs-splats'"),
        ({"version": 2}, "version: is 2, not 1"),
        ({"version": True}, "version: is true, not 1"),
        ({"chunks": {}}, "chunks: is {}, not an object of chunks"),
        ({"chunks": {"ab": [[0, 0]]}}, "chunks: 'ab' is not the id of a chunk"),
        ({"chunks": {A: []}}, rf"chunks\.{A}: is \[\], not a list of ranges"),
        ({"chunks": {A: [[0, 1.5]]}}, rf"chunks\.{A}\[0\]: is \[0, 1.5\], not two whole numbers"),
        ({"chunks": {A: [[4, 5], [5, 6]]}}, rf"chunks\.{A}\[1\]: \[5, 6\] does not ascend from 5"),
        ({"chunks": {A: [[-1, 5]]}}, rf"chunks\.{A}\[0\]: \[-1, 5\] does not ascend from -1"),
    ],
)
def test_a_wrong_field_is_named(tmp_path: Path, change: dict[str, Any], problem: str) -> None:
    right = {"format": "hgs-splats", "version": 1, "chunks": {A: [[0, 0]]}}
    assert load(tmp_path, right).chunks == {A: [(0, 0)]}
    with pytest.raises(InputError, match=rf"list\.json: {problem}"):
        load(tmp_path, right | change)


@pytest.mark.parametrize("text", ["", "[" * 200_000, "[1", '"hgs-splats"', "\xff"])
def test_what_is_no_list_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "list.json"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=r"list\.json: (is not JSON|format: is null)"):
        SplatList.load(file)


def test_all_splats_may_go(tmp_path: Path) -> None:
    viewed = moving()
    whole = listing(tmp_path, {chunk: [[0, count - 1]] for part in (STATIC, *SEGMENTS) for chunk, count in part})
    left = drop_listed(viewed, whole, STATIC, SEGMENTS).viewed
    assert splats(left) == 0
    assert dataclasses.replace(left, scene=viewed.scene) == viewed
