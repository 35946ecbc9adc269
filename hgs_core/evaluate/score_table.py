"""The columns of the table of scores that `hgs eval` prints; eval.json has these fields and more."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["SCORE_COLUMNS", "score_lines"]

SCORE_COLUMNS = (
    "psnr",  # dB, mean over frames and cameras
    "ssim",  # data range 1
    "ms_ssim",
    "lpips",
    "flip",
    "flicker",
    "flicker_steady",  # the truth's own flicker
    "psnr_dynamic",  # dB, pooled over frames and cameras
    "psnr_static",
    "ssim_dynamic",  # mean over all pixels that move
    "lpips_dynamic",
    "psnr_colour_corrected",  # dB, after the best affine colour map of each camera
    "psnr_dynamic_colour_corrected",  # dB, after the same maps
    "psnr_lens_corrected",  # dB, darkened as the training cameras' lenses do on average, then after such maps
    "psnr_dynamic_lens_corrected",
    "magnified",  # dB of larger pictures and nearer eyes, if asked for
    "bytes_total",
    "bytes_static",
    "bytes_dynamic",
    "splats_static",
    "splats_dynamic",
    "train_seconds",
    "frames",
    "cameras",
    "cameras_trained_on",
)


def score_lines(scores: Mapping[str, Any]) -> list[str]:
    """Return a line of text for every score: its column, and its value or "-" where it was not measured."""
    return [f"{name:<29} {_text(value)}" for name, value in scores.items()]


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, dict):
        return ", ".join(f"{name} {_text(score)}" for name, score in value.items())
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "-"
    return f"{value:.4f}" if isinstance(value, float) else str(value)
