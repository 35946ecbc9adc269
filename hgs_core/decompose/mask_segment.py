"""The automatic masks of consecutive frames: deflated bits, in memory or in a file that is mapped.

A file begins with a line of JSON, and the deflated bits of every mask follow, camera after camera.
"""

from __future__ import annotations

import json
import mmap
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.atomic import replacing
from hgs_core.base.errors import InputError

__all__ = ["MaskSegment", "packed_mask", "unpacked_mask"]

_CURE = "delete it and points/near.json, and run hgs train again"


@dataclass(frozen=True)
class MaskSegment:
    """The automatic masks of the cameras that have no given ones."""

    frames: range
    rows: Mapping[int, Sequence[bytes | memoryview]]  # camera -> a mask for each frame, as `packed_mask` makes them

    def packed(self, camera: int, frame: int) -> bytes | memoryview:
        """Return a mask as `packed_mask` made it."""
        return self.rows[camera][self.frames.index(frame)]

    def mask(self, camera: int, frame: int, shape: tuple[int, int]) -> npt.NDArray[np.bool_]:
        """Return a mask of shape [H, W]."""
        return unpacked_mask(self.packed(camera, frame), shape)

    def save(self, path: Path, fingerprint: str) -> None:
        """Write the masks of the capture with this fingerprint; the file appears complete or not at all."""
        sizes = {camera: [memoryview(row).nbytes for row in rows] for camera, rows in self.rows.items()}
        header = {"fingerprint": fingerprint, "first": self.frames.start, "frames": len(self.frames), "sizes": sizes}
        with replacing(path) as file:
            file.write(json.dumps(header, separators=(",", ":")).encode() + b"\n")
            for rows in self.rows.values():
                file.writelines(rows)

    @classmethod
    def load(cls, path: Path, fingerprint: str) -> MaskSegment:
        """Map a file that `save` wrote: a mask is read at its use.

        Raises:
            InputError: the file is missing, damaged, or of another capture.
        """
        try:
            with path.open("rb") as file:
                mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
            header: dict[str, Any] = json.loads(mapped.readline())
            frames = range(int(header["first"]), int(header["first"]) + int(header["frames"]))
            sizes = {int(camera): [int(size) for size in own] for camera, own in header["sizes"].items()}
            theirs = str(header["fingerprint"])
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:  # an empty file cannot be mapped
            raise InputError(path, f"no readable masks ({error})", _CURE) from error
        if theirs != fingerprint:
            raise InputError(path, "the masks belong to another state of the capture", _CURE)
        ends = list(accumulate((size for own in sizes.values() for size in own), initial=mapped.tell()))
        if ends[-1] != len(mapped) or any(len(own) != len(frames) for own in sizes.values()):
            raise InputError(path, "the masks are incomplete", _CURE)
        whole = memoryview(mapped)
        rows = iter([whole[start:end] for start, end in pairwise(ends)])
        return cls(frames, {camera: [next(rows) for _ in own] for camera, own in sizes.items()})


def packed_mask(mask: npt.NDArray[np.bool_]) -> bytes:
    """Return the deflated bits of a mask [H, W]."""
    return zlib.compress(np.packbits(mask).tobytes(), 1)


def unpacked_mask(packed: bytes | memoryview, shape: tuple[int, int]) -> npt.NDArray[np.bool_]:
    """Return the mask of shape [H, W] that `packed_mask` deflated."""
    bits = np.frombuffer(zlib.decompress(packed), np.uint8)
    return np.unpackbits(bits, count=shape[0] * shape[1]).view(np.bool_).reshape(shape)
