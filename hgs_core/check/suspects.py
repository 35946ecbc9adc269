"""Which cameras disagree with the others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hgs_core.check.epipolar import ComparedPairs, camera_errors

__all__ = ["WRONG", "Suspects", "find_suspects"]

WRONG = 3.0  # pixels; right poses of good calibrations come to 0.1 to 0.6, a lens taken for another to 0.7 to 3


@dataclass(frozen=True)
class Suspects:
    """How a rig fares."""

    agreeing: tuple[int, ...]  # cameras that agree with most of their partners
    odd: tuple[int, ...]  # cameras that do not; none where the whole rig is wrong
    unjudged: tuple[int, ...]  # cameras that share no view with another
    errors: tuple[float | None, ...]  # pixels per camera, against the cameras that agree

    @property
    def whole_rig(self) -> bool:
        """Whether no more than half of the judged cameras agree with each other: nobody can say which are right."""
        judged = len(self.errors) - len(self.unjudged)
        return judged > 0 and (len(self.agreeing) < 2 or 2 * len(self.agreeing) < judged)


def find_suspects(
    count: int, errors: Mapping[tuple[int, int], float], pairs: ComparedPairs, wrong: float = WRONG, share: float = 0.5
) -> Suspects:
    """Take away, one after the other, the camera that disagrees with most of those left, until all agree.

    Args:
        count: of the cameras.
        errors: median distance of every pair, pixels.
        pairs: the matches, or what else is compared.
        wrong: distance above which two cameras disagree, pixels.
        share: of its evidence with which a camera disagrees that is taken away.
    """
    judged = {camera for pair in errors for camera in pair}
    left = set(judged)
    while len(left) > 1:
        shares = {camera: _wrong_share(camera, left, errors, pairs, wrong) for camera in sorted(left)}
        worst = max(shares, key=lambda camera: shares[camera])
        if shares[worst] < share:
            break
        left.discard(worst)
    left = {camera for camera in left if any(camera in pair and left.issuperset(pair) for pair in errors)}
    against = []
    for camera in range(count):
        seen = {pair: error for pair, error in errors.items() if camera in pair and left & (set(pair) - {camera})}
        chosen = seen or {pair: error for pair, error in errors.items() if camera in pair}
        against.append(camera_errors(count, chosen, pairs)[camera])
    odd = tuple(sorted(judged - left))
    unjudged = tuple(camera for camera in range(count) if camera not in judged)
    found = Suspects(tuple(sorted(left)), odd, unjudged, tuple(against))
    if found.whole_rig:
        whole = tuple(camera_errors(count, errors, pairs))
        return Suspects(found.agreeing, (), unjudged, whole)
    return found


def _wrong_share(
    camera: int, left: set[int], errors: Mapping[tuple[int, int], float], pairs: ComparedPairs, wrong: float
) -> float:
    """Return the share of the camera's matches with those left that lie in wrong pairs; nought without partners."""
    mine = {pair: error for pair, error in errors.items() if camera in pair and left.issuperset(pair)}
    total = sum(pairs[pair].weight for pair in mine)
    return sum(pairs[pair].weight for pair, error in mine.items() if error > wrong) / total if total else 0.0
