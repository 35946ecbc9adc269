"""The scores that `hgs eval` prints, the moving pixels' beside the whole; eval.json has these fields and more."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["SCORE_COLUMNS", "score_lines"]

_WITH_MOVING = (
    "psnr",  # dB, mean over frames and cameras; where it moves, pooled over them
    "ssim",  # data range 1; where it moves, mean over pixels
    "lpips",
    "psnr_rig",  # the same through the mean lens and the median colour map of the training cameras
    "ssim_rig",
    "lpips_rig",
    "psnr_colour_corrected",  # dB, after the best affine colour map of each camera
    "psnr_lens_corrected",  # dB, through the mean lens, then after such maps
)
_MOVING = {name: name.replace("_", "_dynamic_", 1) if "_" in name else f"{name}_dynamic" for name in _WITH_MOVING}

_ALONE = (
    "psnr_static",  # dB, pooled
    "ms_ssim",
    "flip",
    "flicker",
    "flicker_steady",  # the truth's own flicker
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

_LEARNED = ("lens_falloff", "colour_map")  # lens and colours of the training cameras, null where not learned

SCORE_COLUMNS = (*(field for pair in _MOVING.items() for field in pair), "lpips_network", *_LEARNED, *_ALONE)
"""The fields that `hgs eval --json` prints, in their order."""

_NO_LENS = "as above: the training learned no lens falloff"


def score_lines(scores: Mapping[str, Any]) -> list[str]:
    """Return the lines of a table: names, values, and for some those of the moving pixels.

    A score that was not measured is a dash. Scores through the lens are one line of words where none was learned.
    """
    lines = [f"{'':<29} {'whole':>9} {'moving':>9}"]
    network = scores["lpips_network"]
    for name, moving in _MOVING.items():
        title = f"{name} ({network})" if network and name.startswith("lpips") else name
        if not name.endswith("_rig") or scores["lens_falloff"] is not None:
            lines.append(f"{title:<29} {_text(scores[name]):>9} {_text(scores[moving]):>9}")
        elif name == "psnr_rig":
            lines.append(f"{'psnr_rig, ssim_rig, lpips_rig':<29} {_NO_LENS}")
    return lines + [f"{name:<29} {_text(scores[name])}" for name in _ALONE]


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, dict):
        return ", ".join(f"{name} {_text(score)}" for name, score in value.items())
    if isinstance(value, list):
        return ", ".join(_text(item) for item in value) or "-"
    return f"{value:.4f}" if isinstance(value, float) else str(value)
