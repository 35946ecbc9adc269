"""By how many frames cameras are ahead of others, by how much changes in their pictures from frame to frame.

What starts, stops and turns does so at one moment for all cameras, whatever of it each of them sees. It needs no poses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

__all__ = ["clear_offsets", "energy_offsets"]

_FEWEST = 12  # frames that two cameras must overlap by
_AGREES = 0.75  # frames
_LEAST_AGREEMENT = 0.8  # share of the pairs' weight in the median camera; below it all is chance
_ROUNDS = 30
# Of 200 subsets of 3 to 6 cameras of panoptic_basketball, which is in step, these leave at most 5 % told apart, of
# up to 58 %; of samples/studio with a camera 2 or 3 frames late at least 95 %.
_LIKENESS = 0.8  # correlation with the others
_CLEAR = 0.6  # logarithm of how much more is unlike the others without the offset

Floats = npt.NDArray[np.float64]


def energy_offsets(
    energies: Sequence[Floats | None], farthest: int = 10, least_agreement: float = 0.5
) -> list[float | None]:
    """Return by how many frames, not rounded, each camera is ahead of most; all None where the pairs disagree.

    The energies are those of `PictureChanges`, NaN where a camera was dead; one without any has no offset.
    `farthest` is how many frames two cameras may be apart, `least_agreement` the share of a camera's pairs, by weight,
    that must say the same of it.
    """
    alive = [index for index, energy in enumerate(energies) if energy is not None]
    found = _offsets([energy for energy in energies if energy is not None], farthest, least_agreement)
    offsets: list[float | None] = [None] * len(energies)
    for index, offset in zip(alive, found, strict=True):
        offsets[index] = offset
    return offsets


def clear_offsets(
    energies: Sequence[Floats | None], offsets: Sequence[float | None], apart: float
) -> list[float | None]:
    """Return the offsets; all None where one of more than `apart` frames explains little that none would not.

    Cameras all around a scene see different things move: what they have in common by chance puts them frames apart.
    """
    far = [camera for camera, offset in enumerate(offsets) if offset is not None and abs(offset) > apart]
    clear = all(_is_clear(energies, offsets, camera) for camera in far)
    return list(offsets) if clear else [None] * len(offsets)


def _is_clear(energies: Sequence[Floats | None], offsets: Sequence[float | None], camera: int) -> bool:
    own, offset = energies[camera], offsets[camera]
    assert own is not None
    assert offset is not None
    likeness, gain = [], []
    for energy, other in zip(energies, offsets, strict=True):
        if energy is None or energy is own or other is None:
            continue
        shifted = max(0.0, _correlation(own, energy, round(offset - other)))
        in_step = max(0.0, _correlation(own, energy, round(-other)))
        likeness.append(shifted)
        gain.append(float(np.log((1 - in_step**2 + 1e-6) / (1 - shifted**2 + 1e-6))))
    return bool(likeness) and float(np.median(likeness)) > _LIKENESS and float(np.median(gain)) > _CLEAR


def _offsets(energies: Sequence[Floats], farthest: int, least_agreement: float) -> list[float | None]:
    count = len(energies)
    nothing: list[float | None] = [None] * count
    farthest = min(farthest, len(energies[0]) - _FEWEST) if count else 0
    if farthest < 1 or count < 3:
        return nothing
    leads, weights = np.zeros((count, count)), np.zeros((count, count))
    for a in range(count):
        for b in range(a):
            leads[a, b], weights[a, b] = _lead(energies[a], energies[b], farthest)
            leads[b, a], weights[b, a] = -leads[a, b], weights[a, b]
    if not (weights.sum(axis=1) > 0).all():
        return nothing
    offsets = np.zeros(count)
    for _ in range(_ROUNDS):
        for camera in range(count):
            offsets[camera] = _weighted_median(offsets + leads[camera], weights[camera])
    agrees = np.abs(offsets[:, None] - offsets - leads) < _AGREES
    agreement = (weights * agrees).sum(axis=1) / weights.sum(axis=1)
    if np.median(agreement) < max(least_agreement, _LEAST_AGREEMENT):
        return nothing
    offsets -= np.median(offsets)
    return [
        float(offset) if share >= least_agreement else None for offset, share in zip(offsets, agreement, strict=True)
    ]


def _lead(first: Floats, second: Floats, farthest: int) -> tuple[float, float]:
    """Return by how many frames the first is ahead of the second, and how much that counts."""
    likeness = np.array([_correlation(first, second, shift) for shift in range(-farthest, farthest + 1)])
    best = int(likeness.argmax())
    lead = float(best - farthest)
    if 0 < best < 2 * farthest:
        before, at, after = likeness[best - 1 : best + 2]
        lead += 0.5 * (before - after) / (before - 2 * at + after) if before - 2 * at + after < 0 else 0.0
    return lead, max(0.0, float(likeness[best])) ** 4


def _correlation(first: Floats, second: Floats, shift: int) -> float:
    """Return how the second is like the first when it is moved back by `shift` frames."""
    a, b = first[max(0, -shift) : len(first) - max(0, shift)], second[max(0, shift) : len(second) - max(0, -shift)]
    known = np.isfinite(a) & np.isfinite(b)
    a, b = a[known], b[known]
    if len(a) < _FEWEST or a.std() == 0 or b.std() == 0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def _weighted_median(values: Floats, weights: Floats) -> float:
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(reached, reached[-1] / 2)])
