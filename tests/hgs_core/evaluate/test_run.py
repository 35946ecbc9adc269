from __future__ import annotations

import json
import math
import threading
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, silent
from hgs_core.capture.open import open_capture
from hgs_core.codec import decode_scene
from hgs_core.evaluate.picture_scores import PictureScorer
from hgs_core.evaluate.run import evaluate_run
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene.camera import Camera
from tests.hgs_core.evaluate.conftest import FRAMES, SIZE, finished_run, save
from tests.synthetic import synthetic_scene, write_capture


def test_the_held_out_cameras_are_scored_and_every_frame_is_kept(finished: Path) -> None:
    result = evaluate_run(finished, silent)
    assert result["cameras"] == list(result["per_frame"]) == list(result["per_camera"]) == ["2", "4"]
    assert result["cameras_trained_on"] == []
    series = [result["per_frame"][name]["psnr"] for name in ("2", "4")]
    assert [len(values) for values in series] == [FRAMES, FRAMES]
    assert result["psnr"] == pytest.approx(np.mean(series))
    assert result["per_camera"]["4"]["psnr"] == pytest.approx(np.mean(series[1]))
    assert result["psnr"] > 35  # the scene is the true one: the loss is that of JPEG and of quantised splats
    assert result["flicker"] < 0.02
    assert (result["truth"], result["masks"]) == ("capture", "automatic")


def test_frames_are_scored_side_by_side(finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    score, second_begins, begun = PictureScorer.score, threading.Event(), count()

    def waits_for_the_second(self: PictureScorer, *pictures: Any) -> dict[str, float | None]:
        if next(begun) > 0:
            second_begins.set()
        assert second_begins.wait(60)
        return score(self, *pictures)

    monkeypatch.setenv("HGS_THREADS", "2")
    monkeypatch.setattr(PictureScorer, "score", waits_for_the_second)
    evaluate_run(finished, silent, cameras=["2"])


def test_scores_are_the_same_for_any_number_of_threads(finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    results = []
    for threads in ("1", "5"):
        monkeypatch.setenv("HGS_THREADS", threads)
        results.append(evaluate_run(finished, silent))
    assert results[0] == results[1]


def test_pictures_are_darkened_as_the_lenses_of_training_do(finished: Path) -> None:
    plain = evaluate_run(finished, silent)
    darker = []
    for coefficient in (0.0, -0.3):
        learn(finished, lens_falloff=[coefficient, 0.0])
        darker.append(evaluate_run(finished, silent))
    assert plain["psnr_lens_corrected"] is plain["psnr_dynamic_lens_corrected"] is None
    for name in ("psnr", "psnr_dynamic"):
        assert darker[0][f"{name}_lens_corrected"] == pytest.approx(plain[f"{name}_colour_corrected"], abs=1e-4)
        assert darker[1][f"{name}_lens_corrected"] < plain[f"{name}_colour_corrected"] - 1  # nothing darkens the truth
        assert darker[1][f"{name}_colour_corrected"] == plain[f"{name}_colour_corrected"]


def learn(run: Path, **learned: Any) -> None:
    """Let the training have learned this of its cameras."""
    summary = json.loads((run / "train.json").read_text())
    (run / "train.json").write_text(json.dumps({**summary, **learned}))


def darkening(camera: Camera, a: float, b: float) -> npt.NDArray[np.float64]:
    """Return the gain [H, W, 1] of every pixel."""
    rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
    squares = ((columns - camera.cx) ** 2 + (rows - camera.cy) ** 2) / ((camera.width**2 + camera.height**2) / 4)
    return (1 + a * squares + b * squares**2)[..., None]


def test_the_rig_score_is_that_of_a_picture_darkened_by_hand(finished: Path, capture_folder: Path) -> None:
    """Reference: the decoded scene drawn by the reference renderer, times 1 + a r^2 + b r^4 and a map in numpy."""
    a, b = -0.5, 0.1
    colour_map = np.array([[0.9, 0.05, 0.0, 0.0], [0.0, 0.95, 0.0, 0.01], [0.0, 0.0, 1.05, 0.0]])
    learn(finished, lens_falloff=[a, b], colour_map=colour_map.tolist())
    result = evaluate_run(finished, silent, cameras=["2"])
    capture = open_capture(capture_folder)
    camera = capture.cameras[2]
    scene = decode_scene(finished / "scene").map(torch.from_numpy)
    raw, rig = [], []
    for frame in range(FRAMES):
        view = View(camera, frame / (FRAMES - 1), gradients="none")
        drawn = rasterize_reference(scene.static, scene.segments[0].dynamic, view).rgb.clamp(0, 1).permute(1, 2, 0)
        truth = capture.frame(2, frame) / 255
        shown = drawn.numpy() * darkening(camera, a, b) @ colour_map[:, :3].T + colour_map[:, 3]
        for scores, seen in ((raw, drawn.numpy()), (rig, shown)):
            scores.append(-10 * np.log10(np.mean((seen - truth) ** 2)))
    assert (result["lens_falloff"], result["colour_map"]) == ([a, b], colour_map.tolist())
    assert (result["psnr"], result["psnr_rig"]) == pytest.approx((np.mean(raw), np.mean(rig)), abs=1e-3)
    assert result["psnr_rig"] < result["psnr"] - 1  # no lens darkened this truth


def test_a_rig_that_darkens_corners_scores_high_through_its_lens_alone(
    finished: Path, capture_folder: Path, tmp_path: Path
) -> None:
    capture = open_capture(capture_folder)
    for frame in range(FRAMES):
        darkened = capture.frame(2, frame) * darkening(capture.cameras[2], -0.4, 0.0)
        save(darkened.round().astype(np.uint8), tmp_path / "truth" / "2" / f"{frame:04d}.png")
    learn(finished, lens_falloff=[-0.4, 0.0])
    result = evaluate_run(finished, silent, cameras=["2"], truth=tmp_path / "truth")
    for name in ("psnr", "psnr_dynamic"):
        assert result[f"{name}_rig"] > result[name] + 5


def test_a_run_without_a_lens_says_so_and_has_the_raw_scores_for_the_rig(finished: Path) -> None:
    learn(finished, colour_map=[[0.5, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    result = evaluate_run(finished, silent, cameras=["2"])
    assert result["lens_falloff"] is None
    assert (result["psnr_rig"], result["ssim_rig"]) == (result["psnr"], result["ssim"])


def test_a_camera_is_scored_at_the_moments_when_it_took_its_frames(tmp_path: Path) -> None:
    """Camera 2 films half a frame after the others: the true scene, drawn at their times, would differ."""
    write_capture(tmp_path / "late", frames=FRAMES, width=SIZE[1], height=SIZE[0], late={"2": 0.5})
    result = evaluate_run(finished_run(tmp_path / "run", tmp_path / "late"), silent)
    scores = [camera["psnr"] for camera in result["per_camera"].values()]
    assert min(scores) > 41  # camera 2 scores 37.7 at the times of the others


def test_a_camera_of_training_is_scored_by_the_clock_it_was_trained_with(finished: Path) -> None:
    plain = evaluate_run(finished, silent, cameras=["0", "1"])["per_camera"]
    learn(finished, time_shifts={"1": 0.01})
    shifted = evaluate_run(finished, silent, cameras=["0", "1"])["per_camera"]
    assert shifted["0"] == plain["0"]
    assert shifted["1"]["psnr"] < plain["1"]["psnr"]  # the capture's clocks are right


def test_the_file_is_plain_json(finished: Path, masks_folder: Path) -> None:
    result = evaluate_run(finished, silent, cameras=["2"], masks=masks_folder)

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    assert json.loads((finished / "eval.json").read_text(), parse_constant=refuse) == result


def test_given_masks_tell_the_regions(finished: Path, masks_folder: Path) -> None:
    result = evaluate_run(finished, silent, cameras=["2"], masks=masks_folder)
    assert result["masks"] == "given"
    dynamic = result["per_frame"]["2"]["psnr_dynamic"]
    assert [value is None for value in dynamic] == [True, False, False]
    powers = [10 ** (-value / 10) for value in dynamic[1:]]
    assert result["psnr_dynamic"] == pytest.approx(-10 * math.log10((powers[0] + 2 * powers[1]) / 3), abs=1e-6)
    assert math.isfinite(result["psnr_static"])


def test_lossless_truth_scores_better_than_the_captures_jpeg(
    finished: Path, capture_folder: Path, tmp_path: Path
) -> None:
    capture = open_capture(capture_folder)
    static, dynamic = synthetic_scene()
    for frame in range(FRAMES):
        view = View(capture.cameras[2], frame / (FRAMES - 1), gradients="none")
        picture = rasterize_reference(static, dynamic, view).rgb.clamp(0, 1).permute(1, 2, 0)
        save((picture * 255).round().to(torch.uint8).numpy(), tmp_path / "truth" / "2" / f"{frame:04d}.png")
    lossless = evaluate_run(finished, silent, cameras=["2"], truth=tmp_path / "truth")
    assert lossless["truth"] == "given"
    assert lossless["psnr"] > evaluate_run(finished, silent, cameras=["2"])["psnr"]


def test_cameras_that_were_trained_on_are_told(finished: Path) -> None:
    chosen = evaluate_run(finished, silent, cameras=["4", "1", "4"])
    assert (chosen["cameras"], chosen["cameras_trained_on"]) == (["4", "1"], ["1"])
    reports: list[Progress] = []
    everything = evaluate_run(finished, reports.append, all_cameras=True)
    assert everything["cameras"] == ["0", "1", "2", "3", "4"]
    assert everything["cameras_trained_on"] == ["0", "1", "3"]
    assert [report.done for report in reports] == list(range(1, 5 * FRAMES + 1))
    assert {report.total for report in reports} == {5 * FRAMES}


def test_wrong_wishes_leave_the_last_scores_alone(finished: Path, tmp_path: Path) -> None:
    (finished / "eval.json").write_text("{}")
    with pytest.raises(InputError, match="no camera '9'"):
        evaluate_run(finished, silent, cameras=["9"])
    with pytest.raises(InputError, match="is not a folder"):
        evaluate_run(finished, silent, truth=tmp_path / "absent")
    with pytest.raises(InputError, match=r"w\.npz: unreadable"):
        evaluate_run(finished, silent, lpips=tmp_path / "w.npz")
    assert (finished / "eval.json").read_text() == "{}"
