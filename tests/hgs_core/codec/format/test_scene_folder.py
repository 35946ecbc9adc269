"""Files of a scene folder that differ from the manifest are named."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec import decode_scene
from hgs_core.scene.camera import Camera
from tests.hgs_core.codec.scenes import encode, scene


def test_a_changed_chunk_is_named_with_both_hashes(tmp_path: Path, cameras: list[Camera]) -> None:
    manifest = encode(scene(), tmp_path, cameras)
    file = tmp_path / "chunks" / manifest.static[0].id
    data = bytearray(file.read_bytes())
    data[100] ^= 1
    file.write_bytes(data)
    with pytest.raises(InputError) as caught:
        decode_scene(tmp_path)
    actual = hashlib.sha256(data).hexdigest()
    assert f"{file}: has the SHA-256 {actual}, the manifest says {manifest.static[0].id}" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("damage", ["missing", "short", "of the other kind", "of another count"])
def test_a_chunk_that_is_not_the_manifests_is_named(tmp_path: Path, cameras: list[Camera], damage: str) -> None:
    manifest = encode(scene(), tmp_path, cameras)
    document = json.loads((tmp_path / "manifest.json").read_text())
    file = tmp_path / "chunks" / manifest.static[0].id
    if damage == "missing":
        file.unlink()
    elif damage == "short":
        file.write_bytes(file.read_bytes()[:-1])
    elif damage == "of the other kind":
        document["static"][0], document["slices"][0]["chunks"][0] = (
            document["slices"][0]["chunks"][0],
            document["static"][0],
        )
        document["slices"] = [piece | {"needs": []} for piece in document["slices"]]
    else:
        document["static"][0]["splats"] += 1
    chunks = [chunk for piece in document["slices"] for chunk in piece["chunks"]]
    for kind, listed in (("static", document["static"]), ("dynamic", chunks)):
        for name in ("splats", "bytes"):
            document["totals"][f"{name}_{kind}"] = sum(chunk[name] for chunk in listed)
    (tmp_path / "manifest.json").write_text(json.dumps(document))
    problem = {
        "missing": "cannot be read",
        "short": "bytes, the manifest says",
        "of the other kind": "is a dynamic",
        "of another count": "splats, the manifest says",
    }[damage]
    with pytest.raises(InputError, match=problem):
        decode_scene(tmp_path)
