from __future__ import annotations

import base64
import dataclasses
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from hgs_core.base.progress import silent
from hgs_core.codec import decode_scene
from hgs_core.render.scene_picture import scene_picture
from hgs_core.report import larger_pictures
from hgs_core.report.larger_pictures import LargerPictures, _most_different, draw_larger_pictures
from hgs_core.report.sources import FinishedRun, read_run


@pytest.fixture(scope="module")
def finished(run: Path) -> FinishedRun:
    return read_run(run, silent)


@pytest.fixture(scope="module")
def drawn(finished: FinishedRun) -> LargerPictures:
    return draw_larger_pictures(finished, finished.spec.open_capture(), ["2"], silent)[0]


def test_the_part_is_the_one_where_a_larger_picture_differs_most() -> None:
    plain = torch.full((3, 40, 60), 0.5)
    larger = plain.repeat_interleave(2, 1).repeat_interleave(2, 2)
    larger[:, 50:56, 92:100] = 1.0  # rows 25 to 28, columns 46 to 50
    top, left = _most_different(plain, larger, 10, 15)
    assert top <= 25
    assert top + 10 >= 28
    assert left <= 46
    assert left + 15 >= 50


def test_the_crops_show_one_part_at_each_size(drawn: LargerPictures) -> None:
    assert [crop.factor for crop in drawn.crops] == [1, 2, 4]
    pictures = [_pixels(crop.picture) for crop in drawn.crops]
    assert [picture.shape for picture in pictures] == [(12, 16, 3), (24, 32, 3), (48, 64, 3)]
    assert drawn.crop_size == (64, 48)
    plain = pictures[0]
    for crop, picture in zip(drawn.crops[1:], pictures[1:], strict=True):
        averaged = picture.reshape(12, crop.factor, 16, crop.factor, 3).mean(axis=(1, 3))
        assert np.abs(averaged - plain).mean() < 6  # JPEG's changes of both


def test_the_agreement_is_that_of_the_crops(drawn: LargerPictures) -> None:
    assert drawn.crops[0].agreement is None
    assert all(crop.agreement is not None and crop.agreement > 30 for crop in drawn.crops[1:])


def test_the_crops_are_drawn_with_the_rig(finished: FinishedRun) -> None:
    agreements = []
    for photographed in (True, False):
        manifest = dataclasses.replace(finished.manifest, photographed=photographed)
        pictures = draw_larger_pictures(
            dataclasses.replace(finished, manifest=manifest), finished.spec.open_capture(), ["2"], silent
        )
        agreements.append(pictures[0].crops[2].agreement)
    known, unknown = agreements
    assert known is not None
    assert unknown is not None
    assert known > unknown


def test_the_walk_begins_at_the_camera_and_comes_nearer(finished: FinishedRun, drawn: LargerPictures) -> None:
    scene = decode_scene(finished.folder.scene).map(torch.from_numpy)
    camera = next(camera for camera in finished.manifest.cameras if camera.name == "2")
    plain = scene_picture(scene, camera, drawn.seconds, rig=finished.manifest.rig).rgb.clamp(0, 1)
    walk = [_pixels(picture) for picture in drawn.walk]
    assert len(walk) == 3
    assert np.abs(walk[0] / 255 - plain.permute(1, 2, 0).numpy()).mean() < 0.02
    apart = [np.abs(picture - walk[0]).mean() for picture in walk[1:]]
    assert 2 < apart[0] < apart[1]


def test_pictures_too_large_for_memory_are_left_out(finished: FinishedRun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(larger_pictures, "_MOST_PIXELS", 64 * 48 * 4)
    pictures = draw_larger_pictures(finished, finished.spec.open_capture(), ["2"], silent)[0]
    assert [crop.factor for crop in pictures.crops] == [1, 2]


def _pixels(uri: str) -> np.ndarray:
    with Image.open(BytesIO(base64.b64decode(uri.partition(",")[2]))) as image:
        return np.asarray(image).astype(float)
