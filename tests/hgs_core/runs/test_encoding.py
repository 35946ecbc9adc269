"""A trained scene is encoded as closely as its budget says, from nothing but its run folder."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.codec import load_manifest
from hgs_core.points.near_plane import save_near_planes, with_near_planes
from hgs_core.runs.creation import create_run
from hgs_core.runs.encoding import Encoded, encode, encode_again
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.files import save_scene
from hgs_core.scene.splats import HybridScene, Segment
from tests.synthetic import synthetic_scene, write_capture


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """A run of a filmed scene, "trained" to that very scene, and not encoded yet."""
    path = tmp_path_factory.mktemp("encoding")
    write_capture(path / "capture", frames=2)
    create_run(path / "run", path / "capture", RunConfig.from_json({"capture": {"hold_out": ["2"]}}))
    folder = RunFolder(path / "run")
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    save_scene(folder.trained, HybridScene[np.ndarray](static, (Segment(0.0, 1.0, dynamic),)))
    cameras = folder.open_capture(folder.read_spec()).cameras
    save_near_planes(folder.near_planes, with_near_planes(cameras, np.zeros((50, 3), np.float32)))
    folder.train_summary.write_text('{"iterations": 60}')
    return folder


@pytest.fixture(scope="module")
def encoded(folder: RunFolder) -> Encoded:
    return encode_again(folder.path, None, silent, fine_tune=0)


def test_the_manifest_tells_what_training_said_and_what_encoding_lost(folder: RunFolder, encoded: Encoded) -> None:
    told = load_manifest(folder.scene).training
    assert told["iterations"] == 60
    assert told["encoding_loss"] == round(encoded.loss.whole, 4)
    assert -1 < encoded.loss.whole <= 0.1  # the default budget
    assert encoded.loss.moving is told["encoding_loss_moving"] is None, "no masks tell what moves"


def test_an_encoded_scene_is_kept_until_it_is_asked_for_again(folder: RunFolder, encoded: Encoded) -> None:
    before = folder.manifest.read_bytes()
    encode(folder.path, silent)
    assert folder.manifest.read_bytes() == before
    small = encode_again(folder.path, "low", silent, fine_tune=0)
    assert small.manifest.to_json() == load_manifest(folder.scene).to_json()
    assert small.manifest.totals.bytes_static < encoded.manifest.totals.bytes_static


@pytest.mark.parametrize(("given", "taken"), [(None, 120), (7, 7), (0, 0)])
def test_the_config_states_how_long_a_scene_is_fine_tuned(
    folder: RunFolder, monkeypatch: pytest.MonkeyPatch, given: int | None, taken: int
) -> None:
    spec = folder.read_spec()
    config = spec.config.changed({"train.iterations": 600, "encode.fine_tune": 0.2})
    monkeypatch.setattr(RunFolder, "read_spec", lambda _: dataclasses.replace(spec, config=config))
    asked: list[int] = []

    def stopped(*_: Any, iterations: int, **__: Any) -> NoReturn:
        asked.append(iterations)
        raise InterruptedError

    monkeypatch.setattr("hgs_core.fit.coarseness.fit", stopped)
    with pytest.raises(InterruptedError):
        encode_again(folder.path, None, silent, fine_tune=given)
    assert asked == [taken]


def test_a_run_that_is_not_trained_is_refused(tmp_path: Path) -> None:
    write_capture(tmp_path / "capture", frames=1)
    create_run(tmp_path / "run", tmp_path / "capture", RunConfig.from_json({"capture": {"hold_out": ["2"]}}))
    with pytest.raises(InputError, match=r"scene\.npz"):
        encode(tmp_path / "run", silent)
