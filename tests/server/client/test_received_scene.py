from __future__ import annotations

import hashlib
import json

import pytest

from server.bench.bench_scene import made_up_scene
from server.client.received_scene import ReceivedScene, StreamRefusedError

SCENE = made_up_scene(2, static_bytes=20_000, slice_bytes=3_000)


def test_chunks_are_kept_by_their_names() -> None:
    scene = ReceivedScene("here")
    scene.become(json.loads(SCENE.document))
    assert scene.manifest is not None
    name, data = next(iter(SCENE.chunks.items()))
    scene.take(name, data)
    assert scene.have == {name: data}


def test_a_damaged_chunk_is_refused() -> None:
    scene = ReceivedScene("here")
    with pytest.raises(StreamRefusedError, match="damaged"):
        scene.take(hashlib.sha256(b"a").hexdigest(), b"b")


def test_another_scene_in_its_place_is_refused() -> None:
    scene = ReceivedScene("here")
    scene.become(json.loads(SCENE.document))
    with pytest.raises(StreamRefusedError, match="another scene has taken its place"):
        scene.become(json.loads(made_up_scene(3).document))
