from __future__ import annotations

import base64
import math
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from hgs_core.base.progress import silent
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.render import rasterize
from hgs_core.report.error_colours import error_picture
from hgs_core.report.pictures import _Artist, choose_frames, draw_pictures, evenly
from hgs_core.report.sources import read_run
from hgs_core.scene import DynamicSplats
from tests.hgs_core.report.finished_run import write_finished_run
from tests.synthetic import write_capture


@pytest.mark.parametrize(
    ("psnrs", "chosen", "worst"),
    [
        ([30.0] * 29 + [20.0], [5, 15, 25, 29], 29),
        ([20.0] + [30.0] * 29, [0, 5, 15, 25], 0),
        ([30.0] * 14 + [20.0] + [30.0] * 15, [5, 14, 25], 14),  # 14 shows what 15 would
        ([math.nan] * 7 + [25.0] + [30.0] * 22, [7, 15, 25], 7),
    ],
)
def test_moments_are_spread_evenly_and_hold_the_worst_frame(psnrs: list[float], chosen: list[int], worst: int) -> None:
    assert choose_frames(range(30), psnrs) == (chosen, worst)


def test_a_single_frame_is_shown_once() -> None:
    assert choose_frames([0], [30.0]) == ([0], 0)


def test_evenly_keeps_the_ends() -> None:
    assert evenly(range(10), 4) == [0, 3, 6, 9]
    assert evenly("abc", 4) == ["a", "b", "c"]


def test_dynamic_pixels_are_those_whose_colour_follows_the_dynamic_splats(tmp_path: Path) -> None:
    """Reference: the change of the float64 reference rasterizer's picture as the dynamic splats grow brighter."""
    path = write_finished_run(tmp_path, statics=12)
    run = read_run(path, silent)
    pictures = draw_pictures(run, run.spec.open_capture(), silent)
    scene = decode_scene(run.folder.scene).map(lambda array: torch.tensor(array, dtype=torch.float64))
    camera = next(camera for camera in load_manifest(run.folder.scene).cameras if camera.name == "2")
    shares = []
    for moment in pictures[0].moments:
        segment = scene.segment_at(moment.seconds)
        splats = segment.dynamic
        brighter = DynamicSplats(*(a + 0.25 if name == "rgb" else a for name, a in splats.items()))
        before, after = (
            rasterize(
                scene.static, s, camera, segment.normalised(moment.seconds), backend="reference", gradients="none"
            ).rgb
            for s in (splats, brighter)
        )
        shares.append(float(((after - before)[0] > 0.125).double().mean()))
    assert min(shares) > 0.01
    assert [moment.dynamic_share for moment in pictures[0].moments] == pytest.approx(shares, abs=2 / (64 * 48))


def test_frames_are_drawn_at_the_moments_when_they_were_taken(tmp_path: Path) -> None:
    write_capture(tmp_path / "capture", frames=3, late={"2": 0.5})
    run = read_run(write_finished_run(tmp_path), silent)
    artist = _Artist(run, run.spec.open_capture(), decode_scene(run.folder.scene).map(torch.from_numpy), "2")
    assert min(artist.psnr(frame) for frame in range(3)) > 41  # the last is at 31 dB where the others' time is drawn


def test_the_error_map_shows_the_difference_of_the_two_pictures(tmp_path: Path) -> None:
    """Up to JPEG's changes of all three."""
    run = read_run(write_finished_run(tmp_path, statics=12), silent)
    moment = draw_pictures(run, run.spec.open_capture(), silent)[0].moments[0]
    drawn, truth, error = (_pixels(uri).astype(float) for uri in (moment.drawn, moment.truth, moment.error))
    expected = error_picture(np.abs(drawn - truth).mean(axis=2) / 255)
    assert np.abs(error - expected).mean() < 12


def _pixels(uri: str) -> np.ndarray:
    with Image.open(BytesIO(base64.b64decode(uri.partition(",")[2]))) as image:
        return np.asarray(image)
