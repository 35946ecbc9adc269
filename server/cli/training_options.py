"""The options of a training, shared by `hgs train` and `hgs submit`."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.capture.capture_config import SYNC_BY
from hgs_core.runs.run_config import PRESETS, RunConfig

__all__ = ["add_audio_option", "add_given_options", "add_training_options", "job_settings", "training_config"]


def add_training_options(parser: argparse.ArgumentParser, hold_out: str = "auto") -> None:
    """Add --preset, --hold-out with its default, --trust-poses, --sync, --downscale and --set."""
    parser.add_argument("--preset", choices=list(PRESETS), default="standard", help="how long and how fine to train")
    parser.add_argument(
        "--hold-out",
        metavar="A,B",
        default=hold_out,
        help="cameras kept for `hgs eval`, by name; or none; or auto, of six or more the one in the middle"
        + (" (default)" if hold_out == "auto" else ""),
    )
    parser.add_argument(
        "--trust-poses",
        action="store_true",
        help="train even where the check of the capture finds poses that do not fit",
    )
    parser.add_argument(
        "--sync",
        choices=SYNC_BY,
        help="what tells when videos began that nothing is said of: their sound, what moves, whichever is sure (auto,"
        " the default), or nothing (docs/captures.md)",
    )
    parser.add_argument(
        "--downscale",
        metavar="N",
        type=_reductions,
        help="reduce the pictures N times; big photographs train N^2 times faster. Some cameras' by cam04=4,cam05=2",
    )
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="overrides",
        nargs="+",
        action="extend",
        default=[],
        help="replace fields of the config, e.g. train.iterations=2000 encode.budget=low (docs/training.md)",
    )


def _reductions(text: str) -> tuple[int | None, list[str]]:
    """Return the factor for all cameras, if there is one, and those of single ones as the config has them."""
    parts = [part.strip() for part in text.split(",")]
    whole = [part for part in parts if "=" not in part]
    if len(whole) > 1 or not all(part.isascii() and part.isdecimal() and len(part) < 10 for part in whole):
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not N, or CAMERA=N with commas between them")
    return int(whole[0]) if whole else None, [part for part in parts if "=" in part]


def add_given_options(parser: argparse.ArgumentParser) -> None:
    """Add --masks, --depth and --mesh."""
    parser.add_argument(
        "--masks",
        metavar="FOLDER",
        type=Path,
        help="masks of what moves, <camera>/<FFFF>.png, to use instead of the capture's own (docs/captures.md)",
    )
    parser.add_argument(
        "--depth",
        metavar="FOLDER",
        type=Path,
        help="depth maps of a lidar or a network, <camera>.png of 16 bits or .exr, and depth.json (docs/captures.md)",
    )
    parser.add_argument(
        "--mesh",
        metavar="FILE",
        type=Path,
        help="a surface in the cameras' world: .ply, .obj or .glb (docs/captures.md)",
    )


def add_audio_option(parser: argparse.ArgumentParser, default: str | None, otherwise: str) -> None:
    """Add --audio; `otherwise` describes its default."""
    parser.add_argument(
        "--audio",
        metavar="FILE",
        default=default,
        help="what is heard: a file with sound, camera:NAME for that camera's, auto for the first one's that has any,"
        f" or none; {otherwise} (docs/captures.md)",
    )


def training_config(options: argparse.Namespace) -> RunConfig:
    """Return the config that the options describe.

    Raises:
        InputError: an unknown field, or a value of the wrong type or range.
    """
    config = RunConfig.for_preset(options.preset, **{"capture.hold_out": _held_out(options)})
    return config.changed(_chosen_fields(options)).changed(_overrides(options.overrides))


def job_settings(options: argparse.Namespace) -> dict[str, Any]:
    """Return the fields of `POST /v1/jobs` (docs/rest.md) that the options describe.

    Raises:
        InputError: --set is not followed by KEY=VALUE.
    """
    config = _chosen_fields(options) | _overrides(options.overrides)
    return {"preset": options.preset, "hold_out": _held_out(options), "config": config}


def _held_out(options: argparse.Namespace) -> list[str]:
    """Return the cameras that --hold-out names."""
    names = [name.strip() for name in options.hold_out.split(",") if name.strip()]
    return [] if names == ["none"] else names


def _chosen_fields(options: argparse.Namespace) -> dict[str, Any]:
    """Return the fields of the config that have options of their own, but for the held-out cameras."""
    chosen: dict[str, Any] = {}
    if options.trust_poses:
        chosen["capture.trust_poses"] = True
    if options.sync is not None:
        chosen["capture.sync"] = options.sync
    if options.downscale is not None:
        whole, cameras = options.downscale
        if whole is not None:
            chosen["capture.downscale"] = whole
        chosen["capture.downscale_cameras"] = cameras
    return chosen


def _overrides(assignments: Sequence[str]) -> dict[str, Any]:
    """Read KEY=VALUE pairs, of equal keys the last: the values as JSON where they are JSON, else as strings."""
    overrides: dict[str, Any] = {}
    for assignment in assignments:
        key, equals, text = assignment.partition("=")
        if not (key and equals):
            raise InputError(f"--set {assignment}", "is not KEY=VALUE")
        try:
            overrides[key] = json.loads(text)
        except (ValueError, RecursionError):  # no JSON, or more digits or brackets than Python reads
            overrides[key] = text
    return overrides
