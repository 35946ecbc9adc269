"""The check of a capture before it trains."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from hgs_core.base.progress import Progress, ProgressCallback, silent
from hgs_core.base.wording import counted
from hgs_core.capture.capture import Capture
from hgs_core.check.camera_motion import camera_shift
from hgs_core.check.dead_cameras import judge_dead
from hgs_core.check.epipolar import Pair, Pairs, Rig, camera_errors, pair_errors
from hgs_core.check.evidence import Evidence, gather
from hgs_core.check.findings import CameraResult, CaptureCheck, Finding
from hgs_core.check.given_depth import judge_given_depth
from hgs_core.check.given_masks import judge_masks
from hgs_core.check.interlacing import judge_interlacing
from hgs_core.check.left_handed import judge_left_handed
from hgs_core.check.left_out import judge_left_out
from hgs_core.check.picture_changes import watched_frames
from hgs_core.check.poses import judge_poses
from hgs_core.check.poses_by_motion import PosesByMotion, judge_by_motion
from hgs_core.check.recordings import judge_number, judge_pictures, judge_rates
from hgs_core.check.shown_pairs import shown_pairs
from hgs_core.check.starts_by_features import feature_offsets, match_leads
from hgs_core.check.starts_by_motion import clear_offsets, energy_offsets
from hgs_core.check.suspects import WRONG, find_suspects
from hgs_core.check.synchronise import FEWEST_FRAMES
from hgs_core.check.watched_cameras import Death, WatchedCamera, watch_cameras

__all__ = ["check_capture"]

_APART = 1.0  # frames: what offsets are told from
_APART_IF_SHORT = 1.5  # px, short captures: 20 frames of good ones gave 1.4 by chance


def check_capture(capture: Capture, progress: ProgressCallback = silent) -> CaptureCheck:
    """Check poses, lenses, clocks, masks and pictures of a capture.

    Four moments are matched between cameras, each within itself, without asking the poses; poses are then judged by how
    far the matches lie from the epipolar lines. Equal captures give equal results.

    Raises:
        InputError: a picture or a mask is missing, unreadable or of a wrong size.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> check = hgs.check_capture(hgs.open_capture(Path("capture")))
        >>> len(check.cameras), [finding.problem for finding in check.stops]
        (5, [])
    """
    names = [camera.name for camera in capture.cameras]
    watched = _watched(capture, progress)
    apart = _APART if len(capture.times) >= FEWEST_FRAMES else _APART_IF_SHORT
    energies = [camera.energy() for camera in watched]
    ahead = clear_offsets(energies, energy_offsets(energies), apart)
    by_features = all(offset is None for offset in ahead)
    seen = gather(capture, progress, followed=by_features)
    rig = Rig.of(seen.cameras)
    pairs: Pairs = {pair: Pair.of(matches) for pair, matches in seen.pairs.items()}
    if capture.mirrored:
        findings = judge_left_handed(capture, seen.cameras, pairs)
        suspects, by_motion = (
            find_suspects(len(names), pair_errors(rig, pairs), pairs),
            PosesByMotion((None,) * len(names)),
        )
    else:
        by_motion = judge_by_motion(capture, seen.cameras, pairs, ahead)
        features = [len(view.features[0].xy) for view in seen.views]
        suspects, findings = judge_poses(rig, pairs, names, features, by_motion.judged)
        findings += by_motion.findings
    ahead = [0.0 if index in by_motion.in_step else offset for index, offset in enumerate(ahead)]
    moving = _moving_cameras(names, seen)
    if by_features:
        trusted = set(suspects.agreeing)
        leads = match_leads(rig, [pair for pair in seen.pairs if trusted.issuperset(pair)], seen.views)
        told = feature_offsets(len(names), leads)
        ahead = [None if camera.mostly_dead else offset for camera, offset in zip(watched, told, strict=True)]
    findings += moving + judge_dead(names, watched)
    findings += _unsynchronous(names, ahead, apart, {name for finding in moving for name in finding.cameras})
    findings += judge_pictures(names, seen.views, _blank(names, watched))
    findings += judge_number(seen.cameras) + judge_masks(names, [view.masks for view in seen.views])
    given, about_given = judge_given_depth(capture)
    findings += about_given
    findings += judge_rates(capture.path, names) + judge_interlacing(capture, [camera.changes for camera in watched])
    errors = suspects.errors if pairs else tuple(camera_errors(len(names), {}, pairs))
    results = tuple(
        CameraResult(
            name,
            sum(index in pair for pair in pairs),
            round(sum(one.weight for pair, one in pairs.items() if index in pair)),
            None if errors[index] is None else round(float(errors[index] or 0.0), 3),
            None if ahead[index] is None else round(float(ahead[index] or 0.0), 2),
            None if by_motion.errors[index] is None else round(float(by_motion.errors[index] or 0.0), 2),
        )
        for index, name in enumerate(names)
    )
    findings += judge_left_out(len(names), capture.left_out)
    findings.sort(key=lambda finding: not finding.stops)
    shown = shown_pairs(seen, rig, pair_errors(rig, pairs), suspects)
    return CaptureCheck(
        results, tuple(findings), shown, seen.frames, max(camera.width for camera in seen.cameras), tuple(given)
    )


def _moving_cameras(names: list[str], seen: Evidence) -> list[Finding]:
    findings = []
    for name, view in zip(names, seen.views, strict=True):
        shift = None if view.last is None else camera_shift(view.features[0], view.last)
        if shift is not None:
            first, last = seen.frames[0], seen.frames[-1]
            problem = f"the camera moves: its picture shifts by {shift:.1f} px from frame {first} to {last}"
            cure = "cut the video to where it stands still, or leave the camera out"
            findings.append(Finding(shift > WRONG, (name,), problem, cure))
    return findings


def _watched(capture: Capture, progress: ProgressCallback) -> list[WatchedCamera]:
    count = len(capture.cameras)
    pictures = [partial(capture.frame, index) for index in range(count)]
    frames = watched_frames(len(capture.times))
    return watch_cameras(pictures, frames, lambda done: progress(Progress("check", done, 3 * count)))


def _blank(names: Sequence[str], watched: Sequence[WatchedCamera]) -> set[str]:
    pairs = zip(names, watched, strict=True)
    return {name for name, camera in pairs if any(span.death is Death.BLANK for span in camera.dead)}


def _unsynchronous(names: list[str], ahead: list[float | None], apart: float, moving: set[str]) -> list[Finding]:
    findings = []
    for name, offset in zip(names, ahead, strict=True):
        if offset is not None and abs(offset) > apart and name not in moving:
            frames = float(np.round(abs(offset), 1))
            way = "ahead of" if offset > 0 else "behind"
            problem = f"by what moves, its frames are {frames:g} {way} the others'"
            cut = "the others" if offset > 0 else "it"
            cure = f"cut the first {counted(max(1, round(frames)), 'frame')} of {cut}, or let hgs sync write sync.json"
            findings.append(Finding(False, (name,), problem, cure))
    return findings
