"""Point clouds of Spacetime Gaussian Feature Splatting (Li et al., 2024), its "lite" model: 32 floats, 128 B a splat.

At time t in [0, 1], d = t - trbf_center: position x + sum_k motion[k] d^k, rotation rot + d omega, opacity
sigmoid(opacity) exp(-(d / exp(trbf_scale))^2): our equations, with ln s = -2 trbf_scale. f_dc is the colour itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from hgs_core.base.arrays import Floats
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.gaussian_ply import LARGEST_LOGIT, NO_NEGATIVE_COLOUR, ROT, SCALE
from hgs_core.interchange.ply_table import columns, left_over, write_ply
from hgs_core.scene.at_rest import at_rest
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.scene.temporal import lifetime

__all__ = ["BRIEFEST", "STEADIEST", "is_spacetime", "life_limited", "spacetime_ply", "spacetime_splats"]

CLOCK = ("trbf_center", "trbf_scale")
MOTION = tuple(f"motion_{i}" for i in range(9))
OMEGA = tuple(f"omega_{i}" for i in range(4))
DC = ("f_dc_0", "f_dc_1", "f_dc_2")
FEATURES = ("f_t", "f_dir", "f_rest")  # prefixes of what the full model's network takes
STEADY = 5.0  # trbf_scale with which an opacity changes by less than 1 / 20,000 in [0, 1]
STEADIEST = 10.0  # trbf_scale written for splats that never fade, and the largest
BRIEFEST = -20.0  # of splats that live for one instant, and the least


def is_spacetime(table: Mapping[str, Floats]) -> bool:
    """Return whether a point cloud has times."""
    return CLOCK[0] in table


def spacetime_splats(
    path: Path, table: Mapping[str, Floats]
) -> tuple[StaticSplats[Floats], DynamicSplats[Floats], list[Change]]:
    """Return the splats of a table that `read_ply` read, and what was left out.

    A splat that neither moves nor turns nor fades becomes static.

    Raises:
        InputError: a property is missing.
    """
    means, motion = columns(path, table, ("x", "y", "z")), columns(path, table, MOTION)
    quats, omega = columns(path, table, ROT), columns(path, table, OMEGA)
    center, scale = columns(path, table, CLOCK).T
    dynamic = DynamicSplats(
        np.concatenate([means[:, None], motion.reshape(-1, 3, 3)], axis=1),
        np.stack([quats, omega], axis=1),
        columns(path, table, SCALE),
        columns(path, table, ("opacity",))[:, 0],
        center.copy(),
        -2 * scale,
        columns(path, table, DC),
    )
    still = (motion == 0).all(axis=1) & (omega == 0).all(axis=1) & (scale >= STEADY)
    kept = dynamic.take(still)
    static = StaticSplats(kept.motion[:, 0], kept.log_scales, kept.rotation[:, 0], kept.opacity_logits, kept.rgb)
    known = ("x", "y", "z", *MOTION, *ROT, *OMEGA, *CLOCK, *SCALE, "opacity", *DC)
    changes = left_over(table, known, FEATURES)
    features = {name: array for name, array in table.items() if name.startswith(FEATURES)}
    if features:
        names = ", ".join(sorted({name.rpartition("_")[0] for name in features}))
        met = np.stack(list(features.values()), axis=1) != 0
        reason = "colours are those without the network"
        changes.append(Change.where(Action.LEFT_OUT, f"features {names}", met, reason))
    return static, dynamic.take(~still), changes


def life_limited(dynamic: DynamicSplats[Floats], briefest: float) -> Change:
    """Return the change of limiting ln of the widths of lives to `briefest` to `STEADIEST`."""
    width = dynamic.time_log_precisions.astype(np.float64) / -2
    reason = f"to widths of {np.exp(briefest):.2g} to {np.exp(STEADIEST):.2g} of the time shown"
    return Change.where(Action.LIMITED, "life", (width < briefest) | (width > STEADIEST), reason)


def spacetime_ply(static: StaticSplats[Floats], dynamic: DynamicSplats[Floats]) -> Written:
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
                    splats.motion[:, 0], splats.time_centers[:, None], scale[:, None], np.zeros((len(splats), 3)),
                    splats.motion[:, 1:].reshape(-1, 9), splats.rgb,
                    np.clip(splats.opacity_logits, -LARGEST_LOGIT, LARGEST_LOGIT)[:, None],
                    splats.log_scales, splats.rotation[:, 0], splats.rotation[:, 1],
                ],
                axis=1,
            )
        )  # fmt: skip
    names = ("x", "y", "z", *CLOCK, "nx", "ny", "nz", *MOTION, *DC, "opacity", *SCALE, *ROT, *OMEGA)
    data = write_ply(dict(zip(names, np.concatenate(parts).astype(np.float32).T, strict=True)))
    logits, rgb = (np.concatenate([getattr(part, name) for part in sets]) for name in ("opacity_logits", "rgb"))
    reason = f"to logits of {LARGEST_LOGIT:g}"
    changes = (
        Change(Action.LEFT_OUT, "splats", len(dynamic) - len(living), total, "they are never seen"),
        Change.where(Action.LIMITED, "opacity", np.abs(logits) > LARGEST_LOGIT, reason),
        Change.where(Action.LIMITED, "colour", rgb < 0, NO_NEGATIVE_COLOUR),
        life_limited(living, BRIEFEST),
    )
    return Written(data, changes)
