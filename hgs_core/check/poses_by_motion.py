"""Poses judged by the silhouettes of moving things, for cameras that share too few features."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from hgs_core.capture.capture import Capture
from hgs_core.check.causes import cause_of_camera, cause_of_rig, reading_trials
from hgs_core.check.epipolar import Pairs, Rig, camera_errors, pair_errors
from hgs_core.check.findings import Finding
from hgs_core.check.late_cameras import find_late, moved_error
from hgs_core.check.silhouette_pairs import SilhouettePair, Silhouettes
from hgs_core.check.silhouettes import find_silhouettes, silhouette_frames
from hgs_core.check.suspects import find_suspects
from hgs_core.check.trials import Trial
from hgs_core.scene.camera import Camera

__all__ = ["PosesByMotion", "SilhouettesOfRig", "judge_by_motion"]

_PARTNERS = 2  # cameras that share a view: with fewer features do not tell
_MOST_WITNESSES = 5  # other cameras that those are compared with
_GIVEN, _FOUND = 5.0, 25.0  # pixels: right poses stay below, by given masks and by found motion
_SHARE = 0.75  # share of its pairs that a wrong camera disagrees with; two cameras may see nobody in common
_FEW = 6  # cameras of which one may be late in a rig that is wrong


@dataclass(frozen=True)
class PosesByMotion:
    """The verdict of silhouettes on the poses of cameras."""

    errors: tuple[float | None, ...]  # pixels per camera; None where silhouettes were not asked or do not tell
    findings: tuple[Finding, ...] = ()
    in_step: frozenset[int] = frozenset()  # cameras that fit better as they are than `ahead` would have them

    @property
    def judged(self) -> frozenset[int]:
        """Cameras with a verdict."""
        return frozenset(index for index, error in enumerate(self.errors) if error is not None)


@dataclass(frozen=True)
class SilhouettesOfRig:
    """The silhouettes of some cameras of a capture."""

    names: Sequence[str]  # names of all cameras
    pairs: dict[tuple[int, int], SilhouettePair]  # pairs with enough moments
    given: bool  # whether all are of given masks
    frames_of_step: float  # frames between two moments

    @classmethod
    def of(cls, capture: Capture, sizes: Sequence[Camera], asked: Sequence[int]) -> SilhouettesOfRig:
        """Return those of the cameras `asked`, in pixels of cameras of these sizes.

        Raises:
            InputError: a picture or a mask is unreadable or of a wrong size.
        """
        frames = silhouette_frames(len(capture.times))
        found = {index: find_silhouettes(capture, index, frames, sizes[index]) for index in asked}
        shapes = {index: Silhouettes.of(own) for index, (own, _) in found.items()}
        pairs = {(a, b): SilhouettePair(shapes[a], shapes[b]) for a, b in combinations(sorted(asked), 2)}
        return cls(
            [camera.name for camera in sizes],
            {pair: one for pair, one in pairs.items() if one.tells},
            all(given for _, given in found.values()),
            (len(capture.times) - 1) / max(1, len(frames) - 1),
        )

    @property
    def fits(self) -> float:
        """Pixels below which right poses stay."""
        return _GIVEN if self.given else _FOUND

    def whole_rig(self, rig: Rig, told: str, before: float) -> list[Finding]:
        """Return the findings on a rig of which no camera can be trusted; none where nothing explains it.

        Args:
            rig: its poses as they are.
            told: what is wrong.
            before: pixels by which they do not fit.
        """
        cameras = sorted({camera for pair in self.pairs for camera in pair})
        late = None
        if not rig.mirrored:
            late = find_late([Trial(rig, "", "")], self.pairs, cameras, before, self.fits)
        cause = cause_of_rig(rig, self.pairs, self.names, self.fits)
        if late is not None and (cause is None or late.error < (cause.error or 0.0)):
            return [late.finding(self.names, told, self.frames_of_step)]
        if cause is not None:
            return [cause.finding(True, (), told, self.names)]
        if len(cameras) > _FEW:
            return []
        late = find_late(reading_trials(rig, self.names), self.pairs, cameras, before, self.fits)
        if late is None:
            return []
        cause = late.trial.cause(rig, late.error)
        moved = "what moves does not fit then either"
        return [
            cause.finding(True, (), told, self.names),
            late.finding(self.names, moved, self.frames_of_step),
        ]


def judge_by_motion(
    capture: Capture, sizes: Sequence[Camera], pairs: Pairs, ahead: Sequence[float | None]
) -> PosesByMotion:
    """Judge the cameras with fewer than two partners in `pairs` by the silhouettes of moving things.

    Args:
        capture: its given masks are used where every camera has them, else what differs from the median picture.
        sizes: the cameras at the sizes that distances are measured in.
        pairs: matches of features.
        ahead: frames by which each camera seems ahead of the others, None if unknown: silhouettes may refute it.

    Raises:
        InputError: a picture or a mask is unreadable or of a wrong size.
    """
    count = len(sizes)
    partners = [sum(index in pair for pair in pairs) for index in range(count)]
    doubtful = {index for index in range(count) if partners[index] < _PARTNERS}
    nothing = PosesByMotion((None,) * count)
    if not doubtful or count < 2 or len(capture.times) < 2:
        return nothing
    others = sorted(set(range(count)) - doubtful, key=lambda index: -partners[index])[:_MOST_WITNESSES]
    shapes = SilhouettesOfRig.of(capture, sizes, sorted(doubtful) + others)
    compared = {pair: one for pair, one in shapes.pairs.items() if doubtful & set(pair)}
    if not compared:
        return nothing
    rig, names, fits = Rig.of(sizes), shapes.names, shapes.fits
    off_by = pair_errors(rig, compared)
    suspects = find_suspects(count, off_by, compared, fits, _SHARE)
    errors = tuple(camera_errors(count, off_by, compared))
    shown = tuple(None if error is None or index not in doubtful else error for index, error in enumerate(errors))
    in_step = frozenset(
        index
        for index in doubtful - set(suspects.odd)
        if (error := errors[index]) is not None
        and (later := moved_error(compared, rig, index, -round((ahead[index] or 0.0) / shapes.frames_of_step)))
        is not None
        and error < later / 2
    )
    typical = float(np.median([error for error in errors if error is not None]))
    told_of_all = f"what moves lies {typical:.1f} px from where the poses of all cameras say"
    whole = SilhouettesOfRig(names, compared, shapes.given, shapes.frames_of_step)
    if suspects.whole_rig:
        findings = whole.whole_rig(rig, told_of_all, typical)
        return PosesByMotion(shown, tuple(findings or [_unexplained((), told_of_all)]))
    findings, explained = [], True
    for camera in suspects.odd:
        off = suspects.errors[camera] or 0.0
        mine = {
            pair: one for pair, one in compared.items() if camera in pair and set(pair) <= {camera, *suspects.agreeing}
        }
        told = f"what moves lies {off:.1f} px from where its pose says"
        late = find_late([Trial(rig, "", "")], mine, [camera], off, fits) if mine else None
        cause = cause_of_camera(rig, mine, camera, suspects.agreeing, fits) if mine else None
        if late is not None and (cause is None or late.error < (cause.error or 0.0)):
            findings.append(late.finding(names, told, shapes.frames_of_step))
        elif cause is not None:
            findings.append(cause.finding(True, (names[camera],), told, names))
        else:
            explained = False
            findings.append(_unexplained((names[camera],), told))
    if not explained:  # a wrong reading of all poses may spare two cameras of a level rig
        findings = whole.whole_rig(rig, told_of_all, typical) or findings
    return PosesByMotion(shown, tuple(findings), in_step)


def _unexplained(cameras: tuple[str, ...], told: str) -> Finding:
    cure = "look at the poses, or find them from the videos with hgs cameras; do all cameras show the same people?"
    return Finding(False, cameras, f"{told}: no usual mistake explains it", cure)
