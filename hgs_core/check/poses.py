"""Findings about poses and lenses: which cameras do not fit, and why."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from hgs_core.base.wording import counted
from hgs_core.check.causes import cause_of_camera, cause_of_rig, swapped_cameras
from hgs_core.check.epipolar import Pairs, Rig, pair_errors
from hgs_core.check.findings import Finding
from hgs_core.check.suspects import WRONG, Suspects, find_suspects
from hgs_core.check.trials import Cause, Correction

__all__ = ["judge_poses"]

POOR = 1.0  # pixels: what a careful calibration stays below
_SUSPICIOUS = 0.5  # pixels: from here on a lens may be another than it is taken for
_TELLING = 100  # features of a picture, four times what a match of two takes: smaller pictures may share views unseen
_BY_CHANCE = 50  # matches; what repeats in a scene lets so many of two cameras alone agree, in the wrong place
_FAR_AWAY = 1e4  # rigs' extents from the origin; float32 has seven digits
_AGAIN = "calibrate again, or find poses from the videos with hgs cameras"


def judge_poses(
    rig: Rig, pairs: Pairs, names: Sequence[str], features: Sequence[int] = (), otherwise: Collection[int] = ()
) -> tuple[Suspects, list[Finding]]:
    """Return the measurements of cameras and the findings.

    `features` counts those of each picture; the poses of the cameras `otherwise` are judged by other evidence.
    """
    suspects = find_suspects(len(names), pair_errors(rig, pairs), pairs)
    findings = [] if not pairs else _geometry(rig, pairs, names, suspects)
    return suspects, findings + _without_views(names, suspects, features, otherwise) + _place(rig)


def _geometry(rig: Rig, pairs: Pairs, names: Sequence[str], suspects: Suspects) -> list[Finding]:
    typical = float(np.median([error for error in suspects.errors if error is not None]))
    if suspects.whole_rig:
        return [_whole_rig(rig, pairs, names, typical)]
    findings = _odd_cameras(rig, pairs, names, suspects)
    poor = [i for i in suspects.agreeing if (suspects.errors[i] or 0.0) > POOR]
    if typical > _SUSPICIOUS:
        cause = cause_of_rig(rig, {p: one for p, one in pairs.items() if set(p) <= set(suspects.agreeing)}, names)
        if cause is not None:
            told = f"matches lie {typical:.1f} px from where the poses say"
            return [*findings, cause.finding(False, (), told, names, digits=2)]
    if poor:
        worst = max(suspects.errors[i] or 0.0 for i in poor)
        problem = f"matches lie up to {worst:.1f} px from where the poses say, and good poses stay below {POOR:g}"
        findings.append(Finding(False, tuple(names[i] for i in poor), problem, "what is small will be blurred"))
    return findings


def _whole_rig(rig: Rig, pairs: Pairs, names: Sequence[str], typical: float) -> Finding:
    cause = cause_of_rig(rig, pairs, names)
    told = f"matches lie {typical:.1f} px from where the poses of all cameras say"
    if cause is not None:
        return cause.finding(True, (), told, names, digits=2)
    turns = rig.poses[:, :3, :3]
    if np.abs(turns - turns[0]).max() < 1e-6:
        return Finding(True, (), f"{told}: all poses have the same rotation", "save each camera's own rotation")
    return Finding(True, (), told, f"no usual mistake explains it: {_AGAIN}")


def _odd_cameras(rig: Rig, pairs: Pairs, names: Sequence[str], suspects: Suspects) -> list[Finding]:
    findings, told = [], set()
    for a, b in swapped_cameras(rig, pairs, suspects.odd, suspects.agreeing):
        error = max(suspects.errors[a] or 0.0, suspects.errors[b] or 0.0)
        told_of = f"matches lie {error:.1f} px from where their poses say"
        exchanged = {one: Correction(rig.poses[other], other, 1.0) for one, other in ((a, b), (b, a))}
        cause = Cause("the two are swapped", "exchange their files or their poses", corrections=exchanged)
        findings.append(cause.finding(True, (names[a], names[b]), told_of, names))
        told |= {a, b}
    for camera in suspects.odd:
        off = suspects.errors[camera]
        if camera in told or off is None:
            continue
        known = _same_pose(rig, names, camera) or cause_of_camera(rig, pairs, camera, suspects.agreeing)
        partners = [one for pair, one in pairs.items() if camera in pair]
        if known is None and len(partners) == 1 and partners[0].weight < _BY_CHANCE:
            continue
        cause = known or Cause("no usual mistake explains it", _AGAIN)
        told_of = f"matches lie {off:.1f} px from where its pose says"
        findings.append(cause.finding(off > WRONG, (names[camera],), told_of, names, digits=2))
    return findings


def _same_pose(rig: Rig, names: Sequence[str], camera: int) -> Cause | None:
    centres = rig.centres()
    extent = float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).max())
    near = np.linalg.norm(centres - centres[camera], axis=1) < 1e-6 * extent
    near[camera] = False
    if not near.any():
        return None
    other = names[int(near.argmax())]
    return Cause(f"its pose has it stand where {other} stands", "give each camera its own pose")


def _without_views(
    names: Sequence[str], suspects: Suspects, features: Sequence[int], otherwise: Collection[int]
) -> list[Finding]:
    alone = [names[i] for i in suspects.unjudged if i not in otherwise]
    if not alone:
        return []
    problem = (
        f"{len(alone)} of {counted(len(names), 'camera')} share no view with another: their poses cannot be checked"
    )
    cure = "expect no more than what each of them sees; cameras nearer to each other would help"
    if 1 < len(names) == len(alone) and features and np.median(features) >= _TELLING:
        cure = "are the videos of one scene and one take? Put those there that are"
        return [Finding(True, tuple(alone), problem, cure)]
    return [Finding(False, tuple(alone), problem, cure)]


def _place(rig: Rig) -> list[Finding]:
    centres = rig.centres()
    middle = centres.mean(axis=0)
    extent = float(np.linalg.norm(centres - middle, axis=1).max())
    away = float(np.linalg.norm(middle))
    if extent > 0 and away > _FAR_AWAY * extent:
        problem = f"the rig stands {away:.3g} units from the origin and is {extent:.3g} units large"
        return [Finding(False, (), problem, "move the origin to the rig: positions are kept with seven digits")]
    return []
