"""Point clouds of Spacetime Gaussian Feature Splatting (Li et al., 2024), its "lite" model: 32 floats, 128 B a splat.

At time t in [0, 1], d = t - trbf_center: position x + sum_k motion[k] d^k, rotation rot + d omega, opacity
sigmoid(opacity) exp(-(d / exp(trbf_scale))^2): our equations, with ln s = -2 trbf_scale. f_dc is the colour itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.interchange.gaussian_ply import ROT, SCALE
from hgs_core.interchange.ply_table import columns, write_ply
from hgs_core.scene.at_rest import at_rest
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.scene.temporal import lifetime

__all__ = ["BRIEFEST", "STEADIEST", "is_spacetime", "spacetime_ply", "spacetime_splats"]

CLOCK = ("trbf_center", "trbf_scale")
MOTION = tuple(f"motion_{i}" for i in range(9))
OMEGA = tuple(f"omega_{i}" for i in range(4))
DC = ("f_dc_0", "f_dc_1", "f_dc_2")
STEADY = 5.0  # trbf_scale with which an opacity changes by less than 1 / 20,000 in [0, 1]
STEADIEST = 10.0  # trbf_scale written for splats that never fade, and the largest
BRIEFEST = -20.0  # of splats that live for one instant, and the least

Floats = NDArray[np.float32]


def is_spacetime(table: Mapping[str, Floats]) -> bool:
    """Return whether a point cloud has times."""
    return CLOCK[0] in table


def spacetime_splats(
    path: Path, table: Mapping[str, Floats]
) -> tuple[StaticSplats[Floats], DynamicSplats[Floats], list[str]]:
    """Return the splats of a table that `read_ply` read, and notes on what was left out.

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
        np.maximum(columns(path, table, DC), 0),
    )
    still = (motion == 0).all(axis=1) & (omega == 0).all(axis=1) & (scale >= STEADY)
    kept = dynamic.take(still)
    static = StaticSplats(kept.motion[:, 0], kept.log_scales, kept.rotation[:, 0], kept.opacity_logits, kept.rgb)
    features = sorted({name.rpartition("_")[0] for name in table if name.startswith(("f_t", "f_dir", "f_rest"))})
    notes = [f"features {', '.join(features)} left out: colours are those without the network"] if features else []
    return static, dynamic.take(~still), notes


def spacetime_ply(static: StaticSplats[Floats], dynamic: DynamicSplats[Floats]) -> bytes:
    """Return a .ply file of both sets, statics first; splats that never live are left out."""
    start, end = lifetime(dynamic)
    sets = [at_rest(static), dynamic.take(start <= end)]
    parts = []
    for splats in sets:
        scale = np.clip(splats.time_log_precisions.astype(np.float64) / -2, BRIEFEST, STEADIEST).astype(np.float32)
        parts.append(
            np.concatenate(
                [
                    splats.motion[:, 0], splats.time_centers[:, None], scale[:, None], np.zeros((len(splats), 3)),
                    splats.motion[:, 1:].reshape(-1, 9), splats.rgb, np.clip(splats.opacity_logits, -30, 30)[:, None],
                    splats.log_scales, splats.rotation[:, 0], splats.rotation[:, 1],
                ],
                axis=1,
            )
        )  # fmt: skip
    names = ("x", "y", "z", *CLOCK, "nx", "ny", "nz", *MOTION, *DC, "opacity", *SCALE, *ROT, *OMEGA)
    return write_ply(dict(zip(names, np.concatenate(parts).astype(np.float32).T, strict=True)))
