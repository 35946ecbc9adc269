"""The config of a run's view of its capture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hgs_core.base.config_fields import Range, check_fields
from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import require_storable

if TYPE_CHECKING:
    from hgs_core.capture.capture import Capture

__all__ = ["SYNC_BY", "CaptureConfig"]

SYNC_BY = ("auto", "audio", "motion", "none")
"""The sources for the starts of videos: sound, motion, the surer of both, or none."""

_RANGES: dict[str, Range] = {
    "downscale": (1, 512),  # an 8K picture is 16 pixels wide then, the least that a capture may have
    "frame_memory_mib": (1, 1 << 20),  # a TiB, more than machines have
    "picture_disk_gib": (0, 1 << 20),  # a PiB
}

_MOST_HELD_OUT = 1000  # cameras; no rig has as many
_LONGEST_NAME = 255  # characters; file systems have no longer names, and cameras are called as their files


@dataclass(frozen=True)
class CaptureConfig:
    """Which cameras of a capture a run may see, how large, and how much memory and disk their pictures may take."""

    hold_out: tuple[
        str, ...
    ] = ()  # camera names that neither training nor initialisation may see; ("auto",): one of six
    downscale: int = 1  # pictures are reduced by this factor when they are read, for training and scores alike
    downscale_cameras: tuple[str, ...] = ()  # "cam04=4": those that are reduced by another factor than the others
    frame_memory_mib: int = 1536  # MiB of decoded pictures; those of larger captures are kept on disk
    picture_disk_gib: int = 32  # GiB of decoded pictures on disk; longer captures are visited in blocks that fit
    keep_pictures: bool = False  # whether they stay there when the scene is encoded
    trust_poses: bool = False  # train whatever the check of the capture says
    sync: str = "auto"  # source for unknown starts of videos: auto, audio, motion or none

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: names the field, the value, and the range or the choices.
        """
        check_fields(self, "config.capture", _RANGES, {"sync": SYNC_BY})
        _check_hold_out(self.hold_out)
        _check_reductions(self.downscale_cameras)

    @property
    def cache_bytes(self) -> int:
        """The memory for decoded pictures, bytes."""
        return self.frame_memory_mib << 20

    @property
    def disk_bytes(self) -> int:
        """The room for decoded pictures on disk, bytes."""
        return self.picture_disk_gib << 30

    @property
    def reductions(self) -> dict[str, int]:
        """The factors of the cameras that are not reduced by `downscale`, by name."""
        return {name: int(factor) for name, _, factor in (one.rpartition("=") for one in self.downscale_cameras)}

    def training_cameras(self, capture: Capture) -> tuple[int, ...]:
        """Return the indices of the cameras that initialisation and training may see: all that are not held out.

        Raises:
            InputError: a held-out camera is not one of the capture's.
        """
        held_out = {capture.camera_index(name) for name in self.hold_out}
        return tuple(i for i in range(len(capture.cameras)) if i not in held_out)


def _check_hold_out(names: tuple[str, ...]) -> None:
    where = "config.capture.hold_out"
    if not isinstance(names, tuple) or not all(isinstance(name, str) for name in names):
        raise InputError.of_field(where, "is not a list of camera names")
    if len(names) > _MOST_HELD_OUT:
        raise InputError.of_field(where, f"{len(names)} names are too many", f"give at most {_MOST_HELD_OUT}")
    for name in names:
        require_storable(where, name, _LONGEST_NAME)
    twice = next((name for place, name in enumerate(names) if name in names[:place]), None)
    if twice is not None:
        raise InputError.of_field(where, f"camera {twice} is named twice")


def _check_reductions(given: tuple[str, ...]) -> None:
    where = "config.capture.downscale_cameras"
    if not isinstance(given, tuple) or not all(isinstance(one, str) for one in given):
        raise InputError.of_field(where, "is not a list of texts", 'they are like "cam04=4"')
    if len(given) > _MOST_HELD_OUT:
        raise InputError.of_field(where, f"{len(given)} cameras are too many", f"give at most {_MOST_HELD_OUT}")
    low, high = _RANGES["downscale"]
    names = []
    for one in given:
        require_storable(where, one, _LONGEST_NAME)
        name, _, factor = one.rpartition("=")
        if not (name and factor.isascii() and factor.isdigit() and low <= int(factor) <= high):
            raise InputError.of_field(
                where, f"{one!r} is no camera and factor", f'it is like "cam04=4", from {low} to {high}'
            )
        names.append(name)
    twice = next((name for place, name in enumerate(names) if name in names[:place]), None)
    if twice is not None:
        raise InputError.of_field(where, f"camera {twice} is named twice")
