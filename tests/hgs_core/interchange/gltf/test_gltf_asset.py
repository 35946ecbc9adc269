from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.gltf.gltf_asset import GltfAsset

FLOAT = {"componentType": 5126, "type": "VEC3", "count": 2, "bufferView": 0}


def asset(binary: bytes, *accessors: dict[str, Any], view: dict[str, Any] | None = None, **more: Any) -> GltfAsset:
    """One view of all bytes."""
    whole = {"buffer": 0, "byteLength": len(binary)} | (view or {})
    document = {"accessors": list(accessors), "bufferViews": [whole], "buffers": [{"byteLength": len(binary)}]}
    return GltfAsset(Path("x.glb"), document | more, binary)


def test_floats_are_read_at_their_offsets_and_strides() -> None:
    rows = b"".join(struct.pack("<3f4x", *row) for row in ((1, 2, 3), (4, 5, 6)))
    given = asset(
        b"?" * 8 + rows, FLOAT | {"byteOffset": 4}, view={"byteOffset": 4, "byteStride": 16, "byteLength": 36}
    )
    assert given.numbers(0).tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("component", "code", "stored", "value"),
    [
        (5120, "b", -128, -1.0),
        (5120, "b", 127, 1.0),
        (5121, "B", 51, 0.2),
        (5122, "<h", -32767, -1.0),
        (5123, "<H", 13107, 0.2),
    ],
)
def test_normalised_integers_are_shares_and_others_are_themselves(
    component: int, code: str, stored: int, value: float
) -> None:
    one = {"componentType": component, "type": "SCALAR", "count": 1, "bufferView": 0}
    given = asset(struct.pack(code, stored), one | {"normalized": True}, one)
    assert given.numbers(0)[0, 0] == pytest.approx(value, abs=1e-12)
    assert given.numbers(1)[0, 0] == stored


@pytest.mark.parametrize(
    ("changed", "view", "problem"),
    [
        ({"componentType": 9}, {}, "has accessor 0 of type VEC3 and component type 9"),
        ({"type": "MAT4"}, {}, "has accessor 0 of type MAT4"),
        ({"sparse": {}}, {}, "has accessor 0, which is sparse"),
        ({"bufferView": 1}, {}, "names bufferViews 1 of 1"),
        ({"bufferView": True}, {}, "names bufferViews True of 1"),
        ({"count": 3}, {}, "has accessor 0 of 3 elements in 24 bytes, 12 apart"),
        ({"count": -3}, {}, "has count -3"),
        ({"count": 10**9}, {"byteStride": 0}, "has accessor 0 of 1000000000 elements in 24 bytes, 0 apart"),
        ({}, {"byteOffset": 4}, "has accessor 0 of 2 elements in 20 bytes"),
        ({}, {"byteOffset": 1.5}, "has byteOffset 1.5"),
        ({}, {"buffer": 1}, "names buffers 1 of 1"),
    ],
)
def test_an_array_that_is_not_there_is_named(changed: dict[str, Any], view: dict[str, Any], problem: str) -> None:
    with pytest.raises(InputError) as caught:
        asset(bytes(24), FLOAT | changed, view=view).numbers(0)
    assert str(caught.value).startswith(f"x.glb: {problem}")


def test_bytes_of_another_file_are_not_looked_for() -> None:
    with pytest.raises(InputError, match="keeps accessor 0 outside of its own bytes; save it as one GLB file"):
        asset(bytes(24), FLOAT, buffers=[{"byteLength": 24, "uri": "x.bin"}]).numbers(0)


def places(nodes: list[dict[str, Any]], **more: Any) -> list[np.ndarray]:
    found = asset(b"", nodes=nodes, meshes=[{}], **more).placed_meshes()
    return [np.round(world, 12).tolist() for _, world in found]


def test_a_node_moves_what_it_has_turned_and_scaled_and_its_children_with_it() -> None:
    half = 0.5**0.5
    child = {"mesh": 0, "scale": [2, 3, 4]}
    parent = {"children": [1], "translation": [1, 0, 0], "rotation": [0, 0, half, half]}  # a quarter turn about z
    assert places([parent, child]) == [[[0, -3, 0, 1], [2, 0, 0, 0], [0, 0, 4, 0], [0, 0, 0, 1]]]


def test_a_matrix_is_stored_by_columns() -> None:
    matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]
    assert places([{"mesh": 0, "matrix": matrix}]) == [[[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]]


def test_the_scene_that_is_shown_is_taken_or_without_scenes_all_nodes() -> None:
    nodes = [{"mesh": 0, "translation": [x, 0, 0]} for x in range(3)]
    scenes = [{"nodes": [0]}, {"nodes": [2, 1]}]
    assert [world[0][3] for world in places(nodes, scenes=scenes, scene=1)] == [2, 1]
    assert [world[0][3] for world in places(nodes, scenes=scenes)] == [0]
    assert [world[0][3] for world in places(nodes)] == [0, 1, 2]


@pytest.mark.parametrize(
    ("nodes", "problem"),
    [
        ([{"children": [1]}, {"children": [0]}], "has node 0 in two places"),
        ([{"children": [7]}], "names nodes 7 of 1"),
        ([{"mesh": 3}], "names meshes 3 of 1"),
        ([{"scale": [1, 2]}], "has node 0 in a place that is none"),
        ([{"translation": "here"}], "has node 0 in a place that is none"),
        ([{"translation": [float("nan"), 0, 0]}], "has node 0 in a place that is none"),
        ([3], "has nodes that are no list of objects"),
    ],
)
def test_nodes_that_are_no_tree_are_refused(nodes: list[Any], problem: str) -> None:
    with pytest.raises(InputError) as caught:
        places(nodes, scenes=[{"nodes": [0]}])
    assert str(caught.value).startswith(f"x.glb: {problem}")
