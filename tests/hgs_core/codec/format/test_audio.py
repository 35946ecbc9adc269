from __future__ import annotations

import json
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.audio import AudioEntry, AudioPiece, CodedAudio
from hgs_core.codec.format.manifest_reading import read_manifest
from tests.conftest import REPOSITORY
from tests.json_faults import put

VECTORS = REPOSITORY / "tests" / "vectors"
CASES = json.loads((VECTORS / "audio.json").read_text())


def document() -> dict[str, Any]:
    manifest: dict[str, Any] = json.loads((VECTORS / "manifest.json").read_text())
    return manifest | {"audio": json.loads(json.dumps(CASES["audio"]))}


def test_sound_survives_reading_and_writing_and_need_not_be_there() -> None:
    read = read_manifest(document())
    assert read.to_json()["audio"] == CASES["audio"]
    silent = {name: value for name, value in document().items() if name != "audio"}
    assert read_manifest(silent).audio is None
    assert "audio" not in read_manifest(silent).to_json()


@pytest.mark.parametrize("case", CASES["invalid"], ids=str)
def test_the_wrong_field_is_named(case: dict[str, Any]) -> None:
    changed: Any = document()
    put(changed["audio"], case)
    with pytest.raises(InputError) as raised:
        read_manifest(changed)
    assert raised.value.where == f"manifest.{case['field']}"


def test_a_piece_is_no_chunk_of_splats() -> None:
    changed = document()
    changed["audio"]["pieces"][1]["id"] = changed["static"][0]["id"]
    with pytest.raises(InputError, match=r"audio\.pieces\[1\]\.id"):
        read_manifest(changed)


def test_moved_sound_keeps_the_pieces_that_are_heard() -> None:
    pieces = tuple(AudioPiece(f"{i:064x}", 10, float(i), i + 1.0) for i in range(4))
    sound = CodedAudio(AudioEntry("opus", 48_000, 2, pieces), {piece.id: b"0123456789" for piece in pieces})
    moved = sound.moved(-1.5, 0.0, 1.0)
    assert moved is not None
    assert [(piece.start, piece.end) for piece in moved.entry.pieces] == [(-0.5, 0.5), (0.5, 1.5)]
    assert set(moved.chunks) == {pieces[1].id, pieces[2].id}
    assert sound.moved(20.0, 0.0, 1.0) is None
