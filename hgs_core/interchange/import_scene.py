"""Import of a scene from a file of another format, with omissions and limits."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.antialiasing_note import UNTOLD
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.interchange.drawable import drawable
from hgs_core.interchange.far_places import coarse, middle_if_far, moved
from hgs_core.interchange.file_format import Reading, ReadSplats
from hgs_core.interchange.formats import read_splats
from hgs_core.interchange.ply.ply_sequence import read_sequence
from hgs_core.interchange.sog_writer import META
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment

__all__ = ["USUAL_DURATION", "USUAL_FRAME_RATE", "Imported", "import_scene"]

USUAL_DURATION = 50 / 30  # seconds that a 4D file lasts
USUAL_FRAME_RATE = 30.0  # frames per second of a sequence of still files

LEAST_OPACITY = 1 / 255  # below it no pixel is touched


@dataclass(frozen=True)
class Imported:
    """The content of a file."""

    scene: HybridScene[Floats]
    splats: int  # splats in the file
    changes: tuple[Change, ...]  # omissions and changes
    antialiased: bool | None = None  # whether the scene is drawn so; None: nobody said, and it is assumed not to be


def import_scene(
    path: Path,
    duration: float = USUAL_DURATION,
    frame_rate: float = USUAL_FRAME_RATE,
    *,
    antialiased: bool | None = None,
    activated: bool | None = None,
    centred: bool = True,
) -> Imported:
    """Read a file of splats; a 4D one lasts `duration` seconds, a still one no time.

    A folder is a sequence of still ones, `frame_rate` for each second, unless it holds one scene of many pictures
    (SOG). `antialiased` and `activated` answer what files may not say: whether the splats are drawn antialiased, and
    whether scales and opacities stand there as they are drawn. With `centred`, places far from the origin are moved.

    Splats with non-finite values are dropped, and counted.

    Raises:
        InputError: an unknown suffix, or the file is missing, damaged, ambiguous, or holds no splat that can be seen.
    """
    sequence = path.is_dir() and not (path / META).is_file()
    reading = Reading(activated=activated, centred=centred)
    with np.errstate(all="ignore"):  # non-finite values are counted below
        found = read_sequence(path, reading) if sequence else read_splats(path, reading)
        if found.middle is None and centred:
            found = _centred(found)
        sets = found.dynamic or (DynamicSplats.empty(),)
        steps = () if found.middle is None else coarse(*_places_and_sizes(found))
        total = len(found.static) + sum(map(len, sets))
        if total == 0:
            raise InputError(path, "holds no splats", "give a file with at least one")
        static, sets, changes = drawable(found.static, sets)
    if sequence:
        duration = len(found.dynamic) / frame_rate
    said = [*found.changes, *steps, *changes, *_drawing(found.antialiased, antialiased)]
    logits = np.concatenate([static.opacity_logits, *(dynamic.opacity_logits for dynamic in sets)])
    if not (opacities_of(logits) >= LEAST_OPACITY).any():
        told = "; ".join(map(str, nonzero([*found.changes, *changes])))
        raise InputError(path, "holds no splat that can be seen" + (f": {told}" if told else ""), "export it again")
    equal = np.linspace(0.0, duration if found.lasts else 0.0, len(sets) + 1).tolist()
    ends = (0.0, *found.ends) if found.ends else equal
    segments = tuple(Segment(*between, dynamic) for between, dynamic in zip(pairwise(ends), sets, strict=True))
    drawn = found.antialiased if antialiased is None else antialiased
    scene = HybridScene(static, segments, antialiased=bool(drawn))
    return Imported(scene, total, nonzero(said), drawn)


def _centred(found: ReadSplats) -> ReadSplats:
    """Move splats far from the origin there, for formats with numbers of 32 bits."""
    middle = middle_if_far(_places_and_sizes(found)[0])
    if middle is None:
        return found
    static = dataclasses.replace(found.static, means=(found.static.means - middle).astype(np.float32))
    sets = []
    for dynamic in found.dynamic:
        motion = dynamic.motion.astype(np.float64)
        motion[:, 0] -= middle
        sets.append(dataclasses.replace(dynamic, motion=motion.astype(np.float32)))
    changes = (*found.changes, moved(middle))
    return dataclasses.replace(found, static=static, dynamic=tuple(sets), middle=middle, changes=changes)


def _places_and_sizes(found: ReadSplats) -> tuple[Doubles, Floats]:
    """Return the places [N, 3] of all splats, less the middle, and their log-scales [N, 3]."""
    sets = found.dynamic or (DynamicSplats.empty(),)
    places = [found.static.means, *(dynamic.motion[:, 0] for dynamic in sets)]
    sizes = [found.static.log_scales, *(dynamic.log_scales for dynamic in sets)]
    return np.concatenate(places).astype(np.float64), np.concatenate(sizes)


def _drawing(said: bool | None, given: bool | None) -> list[Change]:
    """Return the notes on drawing: the file's statement, and the user's."""
    if said is None:
        return [UNTOLD] if given is None else []
    if given is None or given == said:
        return []
    option = "--antialiased" if given else "--no-antialiased"
    return [Change.whole(Action.REPLACED, "antialiasing", f"by {option}: the file says otherwise")]
