"""Given masks compared with the motion of the pictures: inverted, misplaced, empty, or of values that mean nothing."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import mask_levels
from hgs_core.check.findings import Finding

__all__ = ["MaskEvidence", "judge_masks", "mask_evidence"]

_ALL = 0.995  # share of pixels
_LEAST_MOTION = 0.002  # share of pixels
_MISPLACED = 0.2  # share of moving pixels; good masks mark 0.55 and more
_MANY_SHADES = 32  # levels
_HALF = 128  # level
_THRESHOLD = "mogrify -threshold 50% {} (ImageMagick) writes 0 and 255"
_MOST_NAMED = 8  # folders

Bools = npt.NDArray[np.bool_]


class MaskFault(Enum):
    """Kinds of wrong masks, the surest first."""

    NO_ZERO = "no zero"
    EVERYTHING = "everything"
    INVERTED = "inverted"
    MISPLACED = "misplaced"
    SHADES = "shades"


@dataclass(frozen=True)
class MaskEvidence:
    """Measurements of a camera's given masks at the moments of a check."""

    marked: tuple[float, ...]  # share of the pixels, per moment
    moving: float = 0.0  # share of the pixels
    of_moving: float = 0.0  # share of the moving pixels that is marked
    of_still: float = 0.0  # share of the other pixels that is marked
    darkest: int = 0  # level of the first mask, as it is stored
    shades: int = 2  # levels of the first mask
    above_half: float = 0.0  # share of its pixels
    first: Path = Path("masks/camera/0.png")  # its file


def mask_evidence(capture: Capture, camera: int, frames: Sequence[int], moves: Sequence[Bools]) -> MaskEvidence | None:
    """Compare a camera's given masks at `frames` with where its pictures move [H, W]; None if it has none.

    `moves` is empty where there is one frame only.

    Raises:
        InputError: a mask is unreadable or of another size than its camera's.
    """
    masks = [mask for mask in (capture.mask(camera, frame) for frame in frames) if mask is not None]
    file = capture.mask_file(camera, frames[0])
    if not masks or file is None:
        return None
    levels = mask_levels(file)
    darkest, shades, half = int(levels.min()), len(np.unique(levels)), float((levels >= _HALF).mean())
    marked = tuple(float(mask.mean()) for mask in masks)
    if not moves:
        return MaskEvidence(marked, darkest=darkest, shades=shades, above_half=half, first=file)
    moving = np.stack(moves)
    at_size = np.stack([_resized(mask, moving.shape[1:]) for mask in masks])
    of_moving = float(at_size[moving].mean()) if moving.any() else 0.0
    of_still = float(at_size[~moving].mean()) if not moving.all() else 0.0
    return MaskEvidence(marked, float(moving.mean()), of_moving, of_still, darkest, shades, half, file)


def judge_masks(names: Sequence[str], evidence: Sequence[MaskEvidence | None]) -> list[Finding]:
    """Report given masks that would have the wrong things trained as moving."""
    given = {name: one for name, one in zip(names, evidence, strict=True) if one is not None}
    if given and all(max(one.marked) == 0 for one in given.values()):
        problem = "the masks mark nothing in the frames that were looked at: what moves would be trained as still"
        return [Finding(False, (), problem, "mark what moves, or take the masks away")]
    faults = {name: _fault(one) for name, one in given.items()}
    findings = []
    for fault in MaskFault:
        cameras = [name for name, found in faults.items() if found is fault]
        if cameras:
            problem, cure = _words(fault, [given[name] for name in cameras])
            cure = cure.format(_files([given[name] for name in cameras], all_of_them=len(cameras) == len(given)))
            findings.append(Finding(False, () if len(cameras) == len(names) else tuple(cameras), problem, cure))
    return findings


def _fault(one: MaskEvidence) -> MaskFault | None:
    if one.darkest > 0 and one.shades > 1:
        return MaskFault.NO_ZERO
    if min(one.marked) > _ALL:
        return MaskFault.EVERYTHING
    if one.moving > _LEAST_MOTION and max(one.marked) > 0:
        if np.mean(one.marked) > 0.5 and one.of_moving < one.of_still:
            return MaskFault.INVERTED
        if one.of_moving < _MISPLACED:
            return MaskFault.MISPLACED
    if one.shades > _MANY_SHADES and one.marked[0] > 1.2 * one.above_half > 0:
        return MaskFault.SHADES
    return None


def _words(fault: MaskFault, masks: Sequence[MaskEvidence]) -> tuple[str, str]:
    """Return the problem and its cure."""
    of_moving = f"{np.mean([one.of_moving for one in masks]):.0%}"
    of_still = f"{np.mean([one.of_still for one in masks]):.0%}"
    match fault:
        case MaskFault.NO_ZERO:
            darkest = min(one.darkest for one in masks)
            return f"the darkest level of the masks is {darkest}, and every level above 0 moves", _THRESHOLD
        case MaskFault.EVERYTHING:
            problem = "the masks mark 100 % of the pixels: nothing would be trained as still"
            return problem, "what moves is above 0, what is still is 0: were they inverted?"
        case MaskFault.INVERTED:
            problem = (
                f"the masks are inverted: they mark {of_still} of the pixels that stand still, {of_moving} of those"
            )
            return f"{problem} that move", "mogrify -negate {} (ImageMagick) exchanges black and white"
        case MaskFault.MISPLACED:
            problem = f"the masks mark {of_moving} of the pixels that move and {of_still} of the others"
            return problem, "are they of other frames, or of another camera? Without their folder masks are computed"
        case MaskFault.SHADES:
            marked = f"{np.mean([one.marked[0] for one in masks]):.1%}"
            half = f"{np.mean([one.above_half for one in masks]):.1%}"
            problem = (
                f"the masks have up to {max(one.shades for one in masks)} levels, as after JPEG or with soft edges"
            )
            return f"{problem}: {marked} of the pixels are above 0 and move, {half} are above half", _THRESHOLD


def _files(masks: Sequence[MaskEvidence], *, all_of_them: bool) -> str:
    """Return the masks of these cameras as a shell's patterns, and of no other."""
    if all_of_them and len({(one.first.parent.parent, one.first.suffix) for one in masks}) == 1:
        return f"{shlex.quote(str(masks[0].first.parent.parent))}/*/*{masks[0].first.suffix}"
    more = f" and so on for {len(masks) - _MOST_NAMED} more" if len(masks) > _MOST_NAMED else ""
    named = (f"{shlex.quote(str(one.first.parent))}/*{one.first.suffix}" for one in masks[:_MOST_NAMED])
    return " ".join(named) + more


def _resized(mask: Bools, shape: tuple[int, ...]) -> Bools:
    height, width = shape
    return np.array(Image.fromarray(mask).resize((width, height), Image.Resampling.NEAREST), bool)
