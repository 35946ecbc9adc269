from __future__ import annotations

import json

from jobs.runs.capture_places import Translation


def test_captures_and_sound_are_named_for_everybody_and_for_this_machine() -> None:
    translation = Translation(lambda path: path.replace("/here", "*"), lambda path: path.replace("*", "/there"))
    spec = {"capture": "/here/take", "audio": "/here/take/sound.wav", "config": {"name": "/here"}}
    portable = translation.portable(json.dumps(spec).encode())
    assert json.loads(portable) == {**spec, "capture": "*/take", "audio": "*/take/sound.wav"}
    local = json.loads(translation.local(portable))
    assert local == {**spec, "capture": "/there/take", "audio": "/there/take/sound.wav"}


def test_what_is_no_path_stays() -> None:
    translation = Translation(lambda path: "elsewhere", lambda path: "here")
    assert json.loads(translation.portable(b'{"audio": null, "iterations": 3}')) == {"audio": None, "iterations": 3}
