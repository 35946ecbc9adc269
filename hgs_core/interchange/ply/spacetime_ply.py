"""Point clouds of Spacetime Gaussian Feature Splatting (Li et al., 2024), its "lite" model: 32 floats, 128 B a splat.

At time t in [0, 1], d = t - trbf_center: position x + sum_k motion[k] d^k, rotation rot + d omega, opacity
sigmoid(opacity) exp(-(d / exp(trbf_scale))^2): our equations, with ln s = -2 trbf_scale. f_dc is the colour itself.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hgs_core.base.arrays import Floats
from hgs_core.interchange.antialiasing_note import note_of, noted_for_us
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.file_format import NOTHING_KNOWN, Reading, ReadSplats
from hgs_core.interchange.ply.gaussian_ply import LARGEST_LOGIT, NO_NEGATIVE_COLOUR
from hgs_core.interchange.ply.ply_table import Table, columns, left_over, write_ply
from hgs_core.interchange.splat_properties import DC, ROT, SCALE, read_properties
from hgs_core.scene.at_rest import at_rest
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.scene.temporal import lifetime

__all__ = ["BRIEFEST", "STEADIEST", "is_spacetime", "life_limited", "spacetime_ply", "spacetime_splats"]

CLOCK = ("trbf_center", "trbf_scale")
MOTION = tuple(f"motion_{i}" for i in range(9))
OMEGA = tuple(f"omega_{i}" for i in range(4))
FEATURES = ("f_t", "f_dir", "f_rest")  # prefixes of what the full model's network takes
STEADY = 5.0  # trbf_scale with which an opacity changes by less than 1 / 20,000 in [0, 1]
STEADIEST = 10.0  # trbf_scale written for splats that never fade, and the largest
BRIEFEST = -20.0  # the least, for splats that live for one instant


def is_spacetime(table: Table) -> bool:
    """Return whether a point cloud has times."""
    return CLOCK[0] in table


def spacetime_splats(path: Path, table: Table, reading: Reading = NOTHING_KNOWN) -> ReadSplats:
    """Return the splats of a table that `read_ply` read, and the omissions.

    A splat that neither moves nor turns nor fades becomes static.

    Raises:
        InputError: a property is missing, or may mean one thing or another.
    """
    found = read_properties(path, table, reading)
    motion, omega = columns(path, table, MOTION), columns(path, table, OMEGA)
    center, scale = columns(path, table, CLOCK).T
    dynamic = DynamicSplats(
        np.concatenate([found.places[:, None], motion.reshape(-1, 3, 3)], axis=1),
        np.stack([found.quats, omega], axis=1),
        found.log_scales,
        found.logits,
        center.copy(),
        -2 * scale,
        found.colours,
    )
    still = (motion == 0).all(axis=1) & (omega == 0).all(axis=1) & (scale >= STEADY)
    kept = dynamic.take(still)
    static = StaticSplats(kept.motion[:, 0], kept.log_scales, kept.rotation[:, 0], kept.opacity_logits, kept.rgb)
    changes = [*found.changes, *left_over(table, (*found.known, *MOTION, *OMEGA, *CLOCK), FEATURES)]
    features = {name: array for name, array in table.items() if name.startswith(FEATURES)}
    if features:
        names = ", ".join(sorted({name.rpartition("_")[0] for name in features}))
        met = np.stack(list(features.values()), axis=1) != 0
        reason = "colours are those without the network"
        changes.append(Change.where(Action.LEFT_OUT, f"features {names}", met, reason))
    moving = (dynamic.take(~still),)
    return ReadSplats(static, moving, lasts=True, middle=found.middle, changes=tuple(changes))


def life_limited(dynamic: DynamicSplats[Floats], briefest: float) -> Change:
    """Return the change of limiting ln of the widths of lives to `briefest` to `STEADIEST`."""
    width = dynamic.time_log_precisions.astype(np.float64) / -2
    reason = f"to widths of {np.exp(briefest):.2g} to {np.exp(STEADIEST):.2g} of the time shown"
    return Change.where(Action.LIMITED, "life", (width < briefest) | (width > STEADIEST), reason)


def spacetime_ply(static: StaticSplats[Floats], dynamic: DynamicSplats[Floats], antialiased: bool = False) -> Written:
    """Return a .ply file of both sets, statics first; splats that never live are left out."""
    start, end = lifetime(dynamic)
    living = dynamic.take(start <= end)
    sets = [at_rest(static), living]
    total = len(static) + len(dynamic)
    parts = []
    for splats in sets:
        scale = np.clip(splats.time_log_precisions.astype(np.float64) / -2, BRIEFEST, STEADIEST).astype(np.float32)
        parts.append(
            np.concatenate(
                [
                    splats.motion[:, 0],
                    splats.time_centers[:, None],
                    scale[:, None],
                    np.zeros((len(splats), 3)),
                    splats.motion[:, 1:].reshape(-1, 9),
                    splats.rgb,
                    np.clip(splats.opacity_logits, -LARGEST_LOGIT, LARGEST_LOGIT)[:, None],
                    splats.log_scales,
                    splats.rotation[:, 0],
                    splats.rotation[:, 1],
                ],
                axis=1,
            )
        )
    names = ("x", "y", "z", *CLOCK, "nx", "ny", "nz", *MOTION, *DC, "opacity", *SCALE, *ROT, *OMEGA)
    table = dict(zip(names, np.concatenate(parts).astype(np.float32).T, strict=True))
    data = write_ply(table, [note_of(antialiased)])
    note = noted_for_us(antialiased)
    logits, rgb = (np.concatenate([getattr(part, name) for part in sets]) for name in ("opacity_logits", "rgb"))
    reason = f"to logits of {LARGEST_LOGIT:g}"
    changes = (
        *([] if note is None else [note]),
        Change(Action.LEFT_OUT, "splats", len(dynamic) - len(living), total, "they are never seen"),
        Change.where(Action.LIMITED, "opacity", np.abs(logits) > LARGEST_LOGIT, reason),
        Change.where(Action.LIMITED, "colour", rgb < 0, NO_NEGATIVE_COLOUR),
        life_limited(living, BRIEFEST),
    )
    return Written(data, changes)
