from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from hgs_core.evaluate.camera_scores import CameraScores, FrameScores, combine
from hgs_core.evaluate.picture_scores import PictureScorer
from hgs_core.evaluate.rig_view import RigView
from hgs_core.metrics.colour_corrected_psnr import ColourCorrectedError, colour_corrected_psnr
from hgs_core.metrics.flicker import flicker
from hgs_core.metrics.psnr import decibels, psnr
from hgs_core.metrics.region_psnr import pooled_region_psnr
from hgs_core.metrics.ssim import ssim, ssim_map
from hgs_core.scene.camera import Camera

SHAPE = (4, 3, 20, 30)


def clip(seed: int) -> tuple[Tensor, Tensor, Tensor]:
    generator = torch.Generator().manual_seed(seed)
    truths = torch.rand(SHAPE[1:], generator=generator) + 0.002 * torch.randn(SHAPE, generator=generator)
    images = truths + 0.02 * (seed + 1) * torch.randn(SHAPE, generator=generator)
    return images, truths, torch.rand(SHAPE[0], *SHAPE[2:], generator=generator) < 0.2


def scored(images: Tensor, truths: Tensor, moving: Tensor | None, rig: RigView | None = None) -> CameraScores:
    scores, scorer = CameraScores(), PictureScorer(None, False)
    for i, (image, truth) in enumerate(zip(images, truths, strict=True)):
        scores.add(FrameScores.of(scorer, image, truth, None if moving is None else moving[i], rig))
    scores.finish()
    return scores


def test_every_score_is_combined_as_its_metric_says() -> None:
    clips = [clip(seed) for seed in range(2)]
    together = combine([scored(*frames) for frames in clips])
    images, truths, moving = (torch.cat(parts) for parts in zip(*clips, strict=True))
    assert together["psnr"] == sum(psnr(*pair) for pair in zip(images, truths, strict=True)) / 8
    assert together["ssim"] == sum(ssim(*pair) for pair in zip(images, truths, strict=True)) / 8
    pooled = [pooled_region_psnr(images, truths, region) for region in (moving, ~moving)]
    torch.testing.assert_close([together["psnr_dynamic"], together["psnr_static"]], pooled)
    corrected = sum(colour_corrected_psnr(*frames[:2]) for frames in clips) / 2
    torch.testing.assert_close(together["psnr_colour_corrected"], corrected)
    torch.testing.assert_close(together["flicker"], sum(flicker(*frames) or 0 for frames in clips) / 2)
    steady = sum(flicker(frames[1][:1].expand(SHAPE), *frames[1:]) or 0 for frames in clips) / 2
    assert steady > 0
    torch.testing.assert_close(together["flicker_steady"], steady)
    assert together["ms_ssim"] is together["lpips"] is together["flip"] is None


def test_every_moving_pixel_counts_once_in_the_scores_of_what_moves() -> None:
    """Reference: the similarity of all moving pixels of both cameras in one list, and the pooled error of both maps."""
    clips = [clip(seed) for seed in range(2)]
    together = combine([scored(*frames) for frames in clips])
    pixels = [ssim_map(x, y)[:, m] for frames in clips for x, y, m in zip(*frames, strict=True)]
    torch.testing.assert_close(together["ssim_dynamic"], float(torch.cat(pixels, 1).mean()), atol=1e-6, rtol=0)
    squared, values = 0.0, 0
    for frames in clips:
        error = ColourCorrectedError()
        for frame in zip(*frames, strict=True):
            error.add(*frame)
        squared, values = squared + error.region_error()[0], values + error.region_error()[1]
    torch.testing.assert_close(together["psnr_dynamic_colour_corrected"], decibels(squared / values))


def camera() -> Camera:
    return Camera("0", 30, 20, 30.0, 30.0, 15.0, 10.0, np.eye(4))


RIG = ("psnr", "ssim", "psnr_dynamic", "ssim_dynamic")


def test_the_rig_scores_are_those_of_pictures_that_the_rig_would_show() -> None:
    images, truths, moving = clip(0)
    rig = RigView([-0.5, 0.1], [[0.9, 0.0, 0.0, 0.1], [0.0, 1.1, 0.0, 0.0], [0.1, 0.0, 1.0, 0.0]], camera())
    by_hand = combine([scored(torch.stack([rig.shown(image) for image in images]), truths, moving)])
    seen, raw = combine([scored(images, truths, moving, rig)]), combine([scored(images, truths, moving)])
    assert {name: seen[f"{name}_rig"] for name in RIG} == {name: by_hand[name] for name in RIG}
    assert {name: seen[name] for name in RIG} == {name: raw[name] for name in RIG}  # raw scores know no lens


def test_without_a_lens_the_rig_sees_the_raw_picture() -> None:
    scores = combine([scored(*clip(0))])
    assert scores["psnr"] is not None
    assert {name: scores[f"{name}_rig"] for name in (*RIG, "lpips")} == {name: scores[name] for name in (*RIG, "lpips")}


def test_frames_have_the_metrics_that_were_measured() -> None:
    frames = clip(0)
    assert {name: len(values) for name, values in scored(*frames).per_frame().items()} == {
        "psnr": 4,
        "ssim": 4,
        "psnr_dynamic": 4,
        "psnr_static": 4,
        "ssim_dynamic": 4,
        "psnr_rig": 4,
        "ssim_rig": 4,
        "psnr_dynamic_rig": 4,
        "ssim_dynamic_rig": 4,
    }
    without_masks = scored(*frames[:2], None)
    assert list(without_masks.per_frame()) == ["psnr", "ssim", "psnr_rig", "ssim_rig"]
    nothing = combine([without_masks])
    assert nothing["psnr_dynamic"] is nothing["ssim_dynamic"] is nothing["psnr_dynamic_colour_corrected"] is None


def test_a_frame_in_which_nothing_moves_has_no_dynamic_score() -> None:
    images, truths, moving = clip(0)
    moving[1] = False
    scores = scored(images, truths, moving).per_frame()
    assert [value is None for value in scores["psnr_dynamic"]] == [False, True, False, False]


def test_an_infinite_score_becomes_none() -> None:
    images, truths, moving = clip(0)
    images[2] = truths[2]
    scores = scored(images, truths, moving)
    assert [value is None for value in scores.per_frame()["psnr"]] == [False, False, True, False]
    assert combine([scores])["psnr"] is None


def test_no_camera_has_no_score() -> None:
    assert set(combine([]).values()) == {None}
