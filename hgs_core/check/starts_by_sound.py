"""When each camera began, by the sound that all of them heard.

Onsets - claps, steps, consonants - stand out of a track whatever its gain, its microphone and the room's echo. Two
tracks are laid on each other where their onsets agree best, to a millisecond or two, and then where their waves do
(GCC-PHAT: Knapp & Carter, IEEE Trans. ASSP, 1976). A pair counts if that place is far better than any other; and the
pairs must agree with each other around every triangle.

Sound takes 3 ms for a metre: cameras that stand at different distances from it hear it at different times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from hgs_core.capture.sound.sound_track import SOUND_RATE

__all__ = ["Heard", "Sounds", "sound_starts"]

_HOP = 64  # samples between two values of the envelope: 4 ms
_WINDOW = 256
_BANDS = 16
_LOWEST = 150.0  # Hz: below it there is wind and hum
_LEAST_OVERLAP = 2.0  # seconds that two tracks must have in common
_SAME_PLACE = 0.06  # seconds: echo smears an onset
_LEAST_HEIGHT = 9.0  # robust deviations of the correlation that the best place is above zero
_MOST_RIVAL = 0.75  # height of the second-best place, of the best one's
_FINE_REACH = 0.008  # seconds around the envelopes' place in which the waves are compared
_FINE_HEIGHT = 7.0  # robust deviations of the waves' correlation
_AGREES = 0.012  # seconds by which a pair may contradict the others: four metres of sound
_LEAST_PARTNERS = 0.5  # share of the cameras that fit each other, which a camera must fit
_MOST_CONTRADICTED = 0.34  # share of a camera's pairs that may contradict the others
_ROUNDS = 40

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Heard:
    """When a camera's first frame was taken."""

    seconds: float  # seconds after the first camera
    confidence: float  # 0..1: how far the places where the tracks fit stand out, in the median over its pairs
    partners: int  # cameras whose tracks agree


@dataclass(frozen=True)
class Sounds:
    """The result of all cameras' tracks."""

    cameras: tuple[Heard | None, ...]  # None: no track, silence, or nothing that others heard, too
    disagreeing: tuple[int, ...]  # cameras that fit others well, at places that contradict each other


@dataclass(frozen=True)
class _Fit:
    lag: float  # seconds by which the second track begins after the first
    confidence: float


def sound_starts(tracks: Sequence[npt.NDArray[np.float32] | None]) -> Sounds:
    """Return when each camera began, from their tracks [N] at `SOUND_RATE`, each beginning with its first frame."""
    count = len(tracks)
    onsets = [None if track is None else _onsets(track) for track in tracks]
    fits: dict[tuple[int, int], _Fit] = {}
    for a in range(count):
        for b in range(a + 1, count):
            first, second = onsets[a], onsets[b]
            if first is not None and second is not None:
                fit = _fit(first, second, tracks[a], tracks[b])
                if fit is not None:
                    fits[a, b] = fit
    group = _largest_group(count, list(fits))
    if not group:
        return Sounds((None,) * count, ())
    starts = _starts(count, group, fits)
    heard: list[Heard | None] = [None] * count
    disagreeing = []
    begin = min(starts[camera] for camera in group)
    for camera in group:
        own = {pair: fit for pair, fit in fits.items() if camera in pair}
        good = [fit.confidence for (a, b), fit in own.items() if abs(starts[b] - starts[a] - fit.lag) <= _AGREES]
        if len(own) < _LEAST_PARTNERS * (len(group) - 1):  # it fits few of those that fit each other
            continue
        heard[camera] = Heard(float(starts[camera] - begin), float(np.median(good)) if good else 0.0, len(good))
        if len(own) - len(good) > _MOST_CONTRADICTED * len(own):
            disagreeing.append(camera)
    return Sounds(tuple(heard), tuple(disagreeing))


def _onsets(track: npt.NDArray[np.float32]) -> Floats | None:
    """Return by how much the loudness of the bands rises, every 4 ms; None of silence."""
    if len(track) < _LEAST_OVERLAP * SOUND_RATE:
        return None
    frames = np.lib.stride_tricks.sliding_window_view(track, _WINDOW)[::_HOP]
    power = np.abs(np.fft.rfft(frames * np.hanning(_WINDOW).astype(np.float32), axis=1)) ** 2
    frequencies = np.fft.rfftfreq(_WINDOW, 1 / SOUND_RATE)
    borders = np.geomspace(_LOWEST, SOUND_RATE / 2, _BANDS + 1)
    bands = [power[:, (frequencies >= low) & (frequencies < high)] for low, high in pairwise(borders)]
    loud = np.stack([band.mean(axis=1) for band in bands if band.shape[1]], axis=1)
    if loud.max() < 1e-9:
        return None
    quiet = np.median(loud, axis=0) + 1e-4 * loud.max()  # constant noise does not count
    rise = np.maximum(np.diff(np.log1p(loud / quiet), axis=0), 0).sum(axis=1)
    smooth = np.convolve(rise, [0.25, 0.5, 0.25], "same")
    return np.asarray(np.minimum(smooth, 8 * np.mean(smooth) + 1e-12) - np.mean(smooth))  # one bang is not all there is


def _fit(
    first: Floats, second: Floats, wave: npt.NDArray[np.float32] | None, other: npt.NDArray[np.float32] | None
) -> _Fit | None:
    """Return by how much the second track begins after the first; None where that is not clear."""
    assert wave is not None
    assert other is not None
    length = 1 << (len(first) + len(second) - 1).bit_length()
    product = np.fft.rfft(first, length) * np.conj(np.fft.rfft(second, length))
    correlation = np.fft.irfft(product, length)
    least = round(_LEAST_OVERLAP * SOUND_RATE / _HOP)
    lags = np.arange(-(len(second) - least), len(first) - least + 1)
    overlap = np.minimum(len(first) - np.maximum(lags, 0), len(second) - np.maximum(-lags, 0))
    likeness = correlation[lags % length] / np.sqrt(overlap)  # chance grows with the root of what is added up
    best = int(likeness.argmax())
    noise = 1.4826 * float(np.median(np.abs(likeness - np.median(likeness)))) + 1e-12
    away = np.abs(lags - lags[best]) * _HOP / SOUND_RATE > _SAME_PLACE
    rival = float(likeness[away].max()) if away.any() else 0.0
    height = float(likeness[best])
    if height < _LEAST_HEIGHT * noise or rival > _MOST_RIVAL * height:
        return None
    place = float(lags[best])
    if 0 < best < len(lags) - 1:
        place += _vertex(*likeness[best - 1 : best + 2])
    lag = place * _HOP / SOUND_RATE
    return _Fit(_refined(wave, other, lag), float(np.clip(1 - max(rival, 0.0) / height, 0, 1)))


def _refined(first: npt.NDArray[np.float32], second: npt.NDArray[np.float32], lag: float) -> float:
    """Return the lag at which the waves themselves fit best near `lag`, or `lag` where they do not clearly."""
    length = 1 << (len(first) + len(second) - 1).bit_length()
    product = np.fft.rfft(first, length) * np.conj(np.fft.rfft(second, length))
    frequencies = np.fft.rfftfreq(length, 1 / SOUND_RATE)
    product[(frequencies < _LOWEST) | (frequencies > 0.9 * SOUND_RATE / 2)] = 0
    size = np.abs(product)
    whitened = np.fft.irfft(product / (size + 1e-3 * size.max() + 1e-20), length)
    centre, reach = round(lag * SOUND_RATE), round(_FINE_REACH * SOUND_RATE)
    lags = np.arange(centre - reach, centre + reach + 1)
    near = whitened[lags % length]
    best = int(near.argmax())
    noise = 1.4826 * float(np.median(np.abs(whitened)))
    if not 0 < best < len(lags) - 1 or near[best] < _FINE_HEIGHT * noise:
        return lag
    return float((lags[best] + _vertex(*near[best - 1 : best + 2])) / SOUND_RATE)


def _vertex(before: float, at: float, after: float) -> float:
    """Return where the parabola through three values has its vertex, from the middle one, -0.5 to 0.5."""
    bend = before - 2 * at + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0


def _largest_group(count: int, pairs: Sequence[tuple[int, int]]) -> list[int]:
    """Return the cameras that the pairs join, of the largest group; of none without pairs."""
    group_of = list(range(count))
    for a, b in pairs:
        old, new = group_of[b], group_of[a]
        group_of = [new if one == old else one for one in group_of]
    groups = [[camera for camera in range(count) if group_of[camera] == one] for one in set(group_of)]
    largest = max(groups, key=lambda group: (len(group), -group[0]))
    return largest if len(largest) > 1 else []


def _starts(count: int, group: Sequence[int], fits: dict[tuple[int, int], _Fit]) -> Floats:
    """Return when the cameras of the group began: each where most of its pairs, by confidence, say so."""
    lags, weights = np.zeros((count, count)), np.zeros((count, count))
    for (a, b), fit in fits.items():
        lags[b, a], lags[a, b] = fit.lag, -fit.lag
        weights[a, b] = weights[b, a] = fit.confidence
    centre = max(group, key=lambda camera: (weights[camera].sum(), -camera))
    starts, known = np.zeros(count), {centre}
    while missing := [c for c in group if c not in known]:  # best-connected camera first
        camera = max(missing, key=lambda c: weights[c, sorted(known)].sum())
        others = sorted(known)
        starts[camera] = _weighted_median(starts[others] + lags[camera, others], weights[camera, others])
        known.add(camera)
    for _ in range(_ROUNDS):
        for camera in group:
            if camera != centre:
                starts[camera] = _weighted_median(starts + lags[camera], weights[camera])
    near = {p: f for p, f in fits.items() if abs(starts[p[1]] - starts[p[0]] - f.lag) <= _AGREES}
    if near:  # the agreeing pairs share what is left: least squares
        rows = np.zeros((len(near) + 1, count))
        wanted = np.zeros(len(near) + 1)
        for row, ((a, b), fit) in enumerate(near.items()):
            rows[row, b], rows[row, a], wanted[row] = fit.confidence, -fit.confidence, fit.confidence * fit.lag
        rows[-1, centre] = 1.0
        solved = np.linalg.lstsq(rows, wanted, rcond=None)[0]
        joined = _largest_group(count, list(near))
        if centre in joined:
            starts[joined] = solved[joined]
    return starts


def _weighted_median(values: Floats, weights: Floats) -> float:
    kept = weights > 0
    values, weights = values[kept], weights[kept]
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weights[order])
    middle = reached[-1] / 2
    low = int(np.searchsorted(reached, middle))
    if np.isclose(reached[low], middle) and low + 1 < len(order):
        return float((values[order][low] + values[order][low + 1]) / 2)
    return float(values[order][low])
