""".4dgs files (Avala AI, version 1): gaussians with a life, one velocity and windows in which they are shown.

At second t a splat is at position + motion (t - mu_t), its opacity times exp(-((t - mu_t) / sigma_t)^2 / 2), and shown
if win_lo <= t < win_hi and that factor is not below the file's cutoff (4dgs.dev/docs/spec). Bytes are read and written
by the library of the format's makers, `fourdgs`, of the extra `4dgs`.
"""

from __future__ import annotations

import io
import itertools
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.antialiasing_note import NOTE, noted, noted_for_us
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.deviations import deviations_limited, deviations_of, log_scales_of
from hgs_core.interchange.file_bytes import file_bytes
from hgs_core.interchange.file_format import FileFormat, ReadSplats
from hgs_core.interchange.light import srgb_replaced, to_srgb
from hgs_core.interchange.ply.gaussian_ply import harmonics
from hgs_core.interchange.straight_pieces import straight_pieces
from hgs_core.scene.at_rest import STEADY
from hgs_core.scene.opacities import logits_of_any, opacities_of
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splats import DynamicSplats, HybridScene, StaticSplats

__all__ = ["FOURDGS", "fourdgs_file", "read_fourdgs"]

CUTOFF = 1 / 255  # share of the opacity in the middle of a life
STILL = 1.0  # seconds that a file of a still scene lasts
NEVER_FADES = -13.8  # ln s with which an opacity changes by less than 1e-6 in a segment
PROFILE = "fine"  # the least of three error bounds: half of 1/255 of colour and opacity, a fiftieth of the median size
SPACE, SRGB, LINEAR = "color_space", "srgb-rec709-display", "linear-rec709-display"
RIGHT_HANDED, DOWN, FORWARD = 1, 4, 2  # our axes: up is -y, forward +z
COLUMNS = ("positions", "scales", "rotations", "colors", "motions", "mu_t", "sigma_t", "win_lo", "win_hi")
Columns = dict[str, Doubles]


def library(path: object) -> ModuleType:
    """Return the package.

    Raises:
        InputError: it is not installed; the message names the extra that has it.
    """
    try:
        import fourdgs
    except ImportError as error:
        raise InputError(path, "needs the package fourdgs", "pip install 'hgs[4dgs]'") from error
    module: ModuleType = fourdgs
    return module


def fourdgs_file(scene: HybridScene[Floats]) -> Written:
    """Return the file of a whole scene: paths as straight pieces, each in its window."""
    package = library(".4dgs")
    length = scene.end - scene.start if scene.end > scene.start else STILL
    sets, pieces, shown, error = [_still(scene.static, length)], 0, 0, 0.0
    for segment in scene.segments:
        span = segment.end - segment.start if segment.end > segment.start else length
        found = straight_pieces(segment.dynamic)
        sets.append(_moving(segment.dynamic, found, segment.start - scene.start, span))
        pieces, error = pieces + len(found.splats), max(error, found.error)
        shown += len(np.unique(found.splats))
    columns = {name: np.concatenate([part[name] for part in sets]) for name in COLUMNS}
    columns["win_hi"][columns["win_hi"] >= length * (1 - 1e-9)] = length + 1e-6  # the last moment is shown
    frame = package.CoordinateFrame(handedness=RIGHT_HANDED, up_axis=DOWN, forward_axis=FORWARD)
    options = package.WriteOptions(
        profile=PROFILE,
        cutoff=CUTOFF,
        library="HGS",
        metadata={SPACE: SRGB, NOTE: str(int(scene.antialiased))},
        provenance=package.Provenance(frames=[frame]),
    )
    buffer = io.BytesIO()
    package.write(buffer, package.GaussianSet(**columns), length, options=options)
    total = len(scene.static) + scene.dynamic_splats
    rgb, scales = (
        np.concatenate([getattr(scene.static, name), *(getattr(part.dynamic, name) for part in scene.segments)])
        for name in ("rgb", "log_scales")
    )
    paths = f"by {pieces:,} straight pieces that do not turn, off by at most {error:.3g} world units"
    stretch = f"0 to {length:g} s of the file stand for {scene.start:g} to {scene.end:g} s"
    same = (scene.start, scene.end) == (0.0, length)
    note = noted_for_us(scene.antialiased)
    changes = (
        *([] if note is None else [note]),
        *([] if same else [Change.whole(Action.REPLACED, "time", stretch)]),
        Change(Action.LEFT_OUT, "splats", scene.dynamic_splats - shown, total, "they are never seen"),
        Change(Action.REPLACED, "motion and turning", shown, total, paths),
        deviations_limited(scales),
        Change.where(Action.LIMITED, "colour", (rgb < 0) | (rgb > 1), "to 0 to 1"),
        Change(Action.ROUNDED, "numbers", total, total, f"within bounds that the file states (profile {PROFILE!r})"),
    )
    return Written(buffer.getvalue(), changes)


def _still(static: StaticSplats[Floats], length: float) -> Columns:
    count = len(static)
    return _columns(static, static.means, unit_quaternions(static.quats)) | {
        "motions": np.zeros((count, 3)),
        "mu_t": np.full(count, length / 2),
        "sigma_t": np.full(count, np.inf),
        "win_lo": np.zeros(count),
        "win_hi": np.full(count, length),
    }


def _moving(dynamic: DynamicSplats[Floats], found: Any, start: float, span: float) -> Columns:
    """Return the pieces of one segment that begins at a second of the file and lasts for `span`."""
    splats = dynamic.take(found.splats)
    center = splats.time_centers.astype(np.float64)
    log_precision = splats.time_log_precisions.astype(np.float64)
    with np.errstate(over="ignore"):
        sigma = np.where(log_precision < NEVER_FADES, np.inf, span * np.exp(-(log_precision + np.log(2)) / 2))
    middle = np.where(np.isinf(sigma), (found.starts + found.ends) / 2, center)
    means = found.means + found.velocities * (middle - center)[:, None]
    return _columns(splats, means, found.quats) | {
        "motions": found.velocities / span,
        "mu_t": start + span * middle,
        "sigma_t": sigma,
        "win_lo": start + span * found.starts,
        "win_hi": start + span * found.ends,
    }


def _columns(splats: StaticSplats[Floats] | DynamicSplats[Floats], means: Doubles | Floats, quats: Doubles) -> Columns:
    opacities = opacities_of(splats.opacity_logits)
    return {
        "positions": np.asarray(means, np.float64),
        "scales": deviations_of(splats.log_scales).astype(np.float64),
        "rotations": quats[:, [1, 2, 3, 0]],
        "colors": np.concatenate([np.clip(splats.rgb, 0, 1), opacities[:, None]], axis=1).astype(np.float64),
    }


def read_fourdgs(path: Path) -> ReadSplats:
    """Read a .4dgs file: splats that are always shown and stand still are static.

    Windows cut the time into segments, and a splat has a copy in each of its own.

    Raises:
        InputError: the library is missing, the file is missing or damaged, or it has another temporal model, tracks of
            objects, or other axes than ours.
    """
    package = library(path)
    data = file_bytes(path, "a .4dgs file")
    try:
        scene = package.read(data, recover_truncated=False)
    except (package.FourdgsError, ValueError) as error:
        raise InputError(path, f"is no .4dgs file that is read here ({error})", "export it again") from error
    found = scene.gaussians
    if scene.objects.tracks:
        raise InputError(path, "moves splats by tracks of objects", "bake them into the splats")
    rgb = np.asarray(found.colors[:, :3], np.float64)
    changes = list(_untold(path, scene))
    if _space(path, scene) == LINEAR:
        rgb = to_srgb(rgb)
        changes.append(srgb_replaced(len(rgb)))
    if found.sh is not None and found.sh_degree:
        changes.append(harmonics(np.abs(np.asarray(found.sh, np.float64) - 127.5) > 1))
    low, high = (np.asarray(edge, np.float64) for edge in (found.win_lo, found.win_hi))
    length = float(scene.duration_sec)
    sigma, motion = np.asarray(found.sigma_t, np.float64), np.asarray(found.motions, np.float64)
    always = (low <= 0) & (high >= length) & np.isinf(sigma) & ~motion.any(axis=1)
    still = StaticSplats(
        np.asarray(found.positions, np.float32),
        log_scales_of(found.scales),
        np.asarray(found.rotations[:, [3, 0, 1, 2]], np.float32),
        logits_of_any(found.colors[:, 3]),
        rgb.astype(np.float32),
    )
    antialiased = noted(f"{NOTE} {value}" for value in _said(scene, NOTE))
    if always.all():
        return ReadSplats(still, antialiased=antialiased, changes=tuple(changes))
    if not 0 < length < np.inf:
        raise InputError(path, f"lasts {length} s, and not all of it stands still", "export it again")
    edges = np.unique(np.clip(np.concatenate([[0.0, length], low[~always], high[~always]]), 0, length))
    edges = edges[np.isfinite(edges)]
    half = np.sqrt(-2 * np.log(max(float(scene.header.cutoff), 1e-9))) * sigma
    first, last = np.maximum(low, found.mu_t - half), np.minimum(high, found.mu_t + half)
    segments = []
    for start, end in itertools.pairwise(edges):
        rows = np.flatnonzero(~always & (low < end) & (high > start) & (first < end) & (last >= start))
        segments.append(_segment(still.take(rows), found, rows, float(start), float(end)))
    copies = sum(map(len, segments)) - int((~always).sum())
    changes.append(
        Change.whole(Action.REPLACED, "windows", f"by {len(segments)} segments, with {max(copies, 0):,} further copies")
    )
    return ReadSplats(
        still.take(always),
        tuple(segments),
        lasts=True,
        ends=tuple(edges[1:].tolist()),
        antialiased=antialiased,
        changes=tuple(changes),
    )


def _segment(
    still: StaticSplats[Floats], found: Any, rows: NDArray[np.intp], start: float, end: float
) -> DynamicSplats[Floats]:
    span = end - start
    sigma, mu = np.asarray(found.sigma_t, np.float64)[rows], np.asarray(found.mu_t, np.float64)[rows]
    velocity = np.asarray(found.motions, np.float64)[rows]
    center = np.where(np.isinf(sigma), (start + end) / 2, mu)
    motion = np.zeros((len(mu), 4, 3))
    motion[:, 0] = still.means + velocity * (center - mu)[:, None]
    motion[:, 1] = velocity * span
    with np.errstate(divide="ignore"):
        log_precision = -np.log(2) - 2 * np.log(sigma / span)
    return DynamicSplats(
        motion.astype(np.float32),
        np.stack([still.quats, np.zeros_like(still.quats)], axis=1),
        still.log_scales,
        still.opacity_logits,
        ((center - start) / span).astype(np.float32),
        np.maximum(log_precision, STEADY).astype(np.float32),
        still.rgb,
    )


def _space(path: Path, scene: Any) -> str:
    """Return the colour space that a file declares; without, colours are sRGB, as the format's registry says."""
    space = next(iter(_said(scene, SPACE)), SRGB)
    if space not in (SRGB, LINEAR):
        raise InputError(path, f"has colours in {space}", f"export it in {SRGB}")
    return space


def _said(scene: Any, name: str) -> list[str]:
    """Return a file's declarations under a name, the latest records first."""
    entries = [*(entry.entries for entry in scene.metadata), scene.header.attributes]
    return [str(one[name]) for one in entries if name in one]


def _untold(path: Path, scene: Any) -> list[Change]:
    """Return the omissions beside splats, and the assumptions."""
    frame = scene.provenance.frame
    changes = []
    if frame is None:
        reason = "the file tells none: they are taken as right, down, forward"
        changes.append(Change.whole(Action.REPLACED, "axes", reason))
    elif (frame.up_axis, frame.forward_axis) != (DOWN, FORWARD) or frame.handedness not in (0, RIGHT_HANDED):
        names = ("+x", "+y", "+z", "-x", "-y", "-z")
        problem = f"has up along {names[frame.up_axis]} and forward along {names[frame.forward_axis]}"
        raise InputError(path, problem, "turn it so that up is -y and forward +z, right-handed")
    if scene.header.cutoff > 1.01 * CUTOFF:
        reason = f"splats end where {scene.header.cutoff:g} of their opacity is left; here they fade on to 1/255"
        changes.append(Change.whole(Action.REPLACED, "ends of lives", reason))
    for what, there in (("sound", scene.audio_sources), ("camera", scene.camera), ("attachments", scene.attachments)):
        if there:
            changes.append(Change.whole(Action.LEFT_OUT, what, "a scene has none such"))
    return changes


FOURDGS = FileFormat(
    ".4dgs", read=lambda path, reading: read_fourdgs(path), write_whole=lambda scene, _: fourdgs_file(scene)
)
