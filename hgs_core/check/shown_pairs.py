"""Pairs of pictures that show people the meaning of the figures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hgs_core.check.epipolar import Rig
from hgs_core.check.evidence import Evidence
from hgs_core.check.findings import ShownMatch, ShownPair
from hgs_core.check.suspects import Suspects

__all__ = ["shown_pairs"]

_MOST_PAIRS = 3
_MATCHES = 8


def shown_pairs(
    seen: Evidence, rig: Rig, errors: Mapping[tuple[int, int], float], suspects: Suspects
) -> tuple[ShownPair, ...]:
    """Return up to three pairs: of each odd camera its best-matched one, of a good rig the worst of all."""
    chosen: list[tuple[int, int]] = []
    for camera in suspects.odd:
        mine = [pair for pair in errors if camera in pair and set(pair) & set(suspects.agreeing)]
        chosen += sorted(mine, key=lambda pair: -len(seen.pairs[pair].rows))[:1]
    if not chosen:
        chosen = sorted(errors, key=lambda pair: -errors[pair])[:1]
    return tuple(_shown(seen, rig, pair, errors[pair]) for pair in chosen[:_MOST_PAIRS])


def _shown(seen: Evidence, rig: Rig, pair: tuple[int, int], error: float) -> ShownPair:
    a, b = pair
    matches, fundamental = seen.pairs[pair], rig.fundamental(a, b)
    moment = int(np.bincount(matches.moments).argmax())
    rows = np.flatnonzero(matches.moments == moment)
    # Spread over the picture: from left to right, evenly.
    rows = rows[np.argsort(matches.first[rows, 0], kind="stable")]
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, _MATCHES).round().astype(int))]
    shown = []
    for row in rows:
        line = fundamental @ np.append(matches.first[row], 1.0)
        length = float(np.hypot(line[0], line[1]))
        if length > 0:
            first, second = matches.first[row].round(1).tolist(), matches.second[row].round(1).tolist()
            x, y, offset = (line / length).tolist()
            shown.append(ShownMatch((first[0], first[1]), (second[0], second[1]), (x, y, offset)))
    cameras = seen.cameras[a], seen.cameras[b]
    sizes = (cameras[0].width, cameras[0].height), (cameras[1].width, cameras[1].height)
    return ShownPair((cameras[0].name, cameras[1].name), seen.frames[moment], sizes, round(error, 3), tuple(shown))
