"""How well offsets are found of videos that are shifted against each other.

    python -m scripts.measure_sync CAPTURE [--seed N] [--step 2]

Every camera of a synchronous capture begins up to seven frames earlier or later, at random. With `--step 2` every
second frame is left out, so that shifts are of half frames.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import cast

import numpy as np
import numpy.typing as npt

from hgs_core.base.progress import silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.check.synchronise import find_offsets

__all__ = ["main"]

_LARGEST = 7  # frames


class _Shifted:
    """The part of a capture that `find_offsets` uses, with other first frames."""

    def __init__(self, capture: Capture, shifts: npt.NDArray[np.float64], step: int) -> None:
        self._capture, self._step = capture, step
        self._first = [round((_LARGEST + shift) * step) for shift in shifts]
        self.path, self.cameras = capture.path, capture.cameras
        self.times = np.arange((len(capture.times) - 2 * _LARGEST * step) // step, dtype=np.float64)

    def frame(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        return self._capture.frame(camera, self._first[camera] + frame * self._step)


def main() -> None:
    """Shift, find, and print how far the offsets found are from those that were made."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("capture", type=Path)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--step", type=int, default=1)
    options = parser.parse_args()
    capture = open_capture(options.capture)
    numbers = np.random.default_rng(options.seed)
    largest = _LARGEST * options.step
    shifts = numbers.integers(-largest, largest + 1, len(capture.cameras)) / options.step
    began = time.process_time()
    found = find_offsets(cast(Capture, _Shifted(capture, shifts, options.step)), silent)
    off = np.array([np.nan if one is None else one - shift for one, shift in zip(found, shifts, strict=True)])
    off = np.abs(off - np.nanmedian(off))
    print(f"{int((off <= 0.5).sum())} of {len(off)} within half a frame, {found.count(None)} not told")
    print(f"largest error {np.nanmax(off):.2f} frames, {time.process_time() - began:.0f} CPU seconds")


if __name__ == "__main__":
    main()
