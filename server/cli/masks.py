"""`hgs masks CAPTURE --out FOLDER`: motion masks as pictures to view and edit."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import StageStopped, interruptible
from hgs_core.base.writable import require_writable_folder
from server.cli.interrupts import Interrupts
from server.cli.progress_bars import ProgressBars

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "masks",
        help="write the masks of what moves",
        description="Write masks of what moves as PNG files. Edit them and give them to hgs train --masks.",
    )
    parser.add_argument("capture", metavar="CAPTURE", type=Path, help="folder of a multi-view video")
    parser.add_argument("--out", metavar="FOLDER", type=Path, required=True, help="new folder for the masks")
    parser.add_argument(
        "--sam",
        metavar="WEIGHTS",
        type=Path,
        help="sharpen the automatic masks with SAM 2: a folder of weights in the format of transformers (extra sam)",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.capture.open import open_capture
    from hgs_core.decompose.mask_pictures import export_masks, require_new_folder
    from hgs_core.decompose.masks import motion_masks

    require_new_folder(options.out)
    require_writable_folder(options.out)
    capture = open_capture(options.capture)
    if len(capture.times) == 1:
        raise InputError(options.capture, "all pictures are of one moment", "nothing moves, no masks are needed")
    refiner = None
    if options.sam is not None:
        from hgs_core.decompose.sam import Sam2Refiner

        refiner = Sam2Refiner(options.sam)
    for note in capture.notes:
        print(f"{options.capture}: {note}", file=sys.stderr)
    frames = range(len(capture.times))
    with Interrupts() as interrupts, ProgressBars(interrupts) as bars, interruptible():
        try:

            def numbers(camera: int) -> list[int]:
                return [capture.number(camera, frame) for frame in frames]

            found = motion_masks(capture, range(len(capture.cameras)), progress=bars)

            def of_camera(camera: int) -> Iterable[npt.NDArray[np.bool_]]:
                masks = [found.mask(camera, frame) for frame in frames]
                if refiner is None or capture.mask(camera, 0) is not None:
                    return masks
                return refiner.refine([capture.frame(camera, frame) for frame in frames], masks)

            names = [camera.name for camera in capture.cameras]
            export_masks(options.out, names, of_camera, numbers=numbers, progress=bars)
        except StageStopped:
            return 130
    print(options.out)
    return 0
