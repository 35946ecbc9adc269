"""Makes a capture in which little moves: one with true masks, of which all but one object is frozen.

    .venv/bin/python -m scripts.experiments.one_mover samples/studio STUDIO/masks OUT --object 14

Masks are STUDIO/masks/<camera>/<FFFF>.png, of object numbers. Every picture is the first one of its camera, but where
the object is or was in the first picture it is the true one. Shadows and reflections are frozen. OUT is in the layout
of PanopticSports; OUT/event has the masks of the object, for `hgs eval RUN --masks OUT/event`.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from hgs_core.capture.open import open_capture
from hgs_core.decompose.morphology import dilate
from scripts.make_event_capture import capture_meta, save_picture

__all__ = ["thawed"]

_MARGIN = 2  # pixels around the object: its edges are mixed with what is behind

Picture = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]


def thawed(first: Picture, now: Picture, was: Mask, is_now: Mask) -> Picture:
    """Return the first picture [H, W, 3] with what is there now where an object was [H, W] or is."""
    return np.where(dilate(was | is_now, _MARGIN)[..., None], now, first)


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("capture", type=Path)
    parser.add_argument("masks", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--object", type=int, required=True, help="its number in the masks")
    given = parser.parse_args()
    capture = open_capture(given.capture)
    given.out.mkdir(parents=True)
    for index, camera in enumerate(capture.cameras):
        first = capture.frame(index, 0)
        files = [given.masks / camera.name / f"{frame:04d}.png" for frame in range(len(capture.times))]
        own = [np.asarray(Image.open(file)) == given.object for file in files]
        for frame, mask in enumerate(own):
            picture = thawed(first, capture.frame(index, frame), own[0], mask)
            save_picture(given.out / "ims" / camera.name / f"{frame:06d}.png", picture)
            save_picture(given.out / "event" / camera.name / f"{frame:04d}.png", np.asarray(mask * 255, np.uint8))
    (given.out / "train_meta.json").write_text(json.dumps(capture_meta(capture)))


if __name__ == "__main__":
    main()
