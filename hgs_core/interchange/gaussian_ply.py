"""Point clouds of 3D Gaussian Splatting (Kerbl et al., 2023): .ply with logits, log-scales and spherical harmonics.

World and rotations are ours (OpenCV axes, quaternions w, x, y, z). Colour is 0.5 + SH_0 f_dc, not below 0 when drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.ply_table import columns, left_over, write_ply
from hgs_core.scene.splats import StaticSplats

__all__ = [
    "LARGEST_LOGIT",
    "NO_NEGATIVE_COLOUR",
    "ROT",
    "SCALE",
    "SH_0",
    "gaussian_ply",
    "gaussian_splats",
    "harmonics",
]

SH_0 = 0.28209479177387814
"""The constant spherical harmonic, 1 / (2 sqrt(pi))."""

SCALE = ("scale_0", "scale_1", "scale_2")
ROT = ("rot_0", "rot_1", "rot_2", "rot_3")
LARGEST_LOGIT = 30.0  # of an opacity that is written: viewers take the sigmoid
NO_NEGATIVE_COLOUR = "viewers of the format draw none below 0"
_DC = ("f_dc_0", "f_dc_1", "f_dc_2")
_PLACE = ("x", "y", "z")


def gaussian_splats(path: Path, table: Mapping[str, Floats]) -> tuple[StaticSplats[Floats], list[Change]]:
    """Return the splats of a table that `read_ply` read from `path`, and what was left out.

    Raises:
        InputError: a property is missing.
    """
    splats = StaticSplats(
        columns(path, table, _PLACE),
        columns(path, table, SCALE),
        columns(path, table, ROT),
        columns(path, table, ("opacity",))[:, 0],
        (0.5 + SH_0 * columns(path, table, _DC)).astype(np.float32),
    )
    changes = left_over(table, (*_PLACE, *SCALE, *ROT, "opacity", *_DC), ("f_rest_",))
    rest = [array for name, array in table.items() if name.startswith("f_rest_")]
    return splats, [*changes, harmonics(np.stack(rest, axis=1) != 0)] if rest else changes


def harmonics(met: NDArray[np.bool_]) -> Change:
    """Return the change of leaving out the harmonics above degree 0: `met` [N, C] tells which are not zero."""
    degree = round((met.shape[1] / 3 + 1) ** 0.5) - 1
    reason = f"spherical harmonics of degree 1 to {degree}: colours are the same from every direction"
    return Change.where(Action.LEFT_OUT, "view-dependent colour", met, reason)


def gaussian_ply(splats: StaticSplats[Floats]) -> Written:
    """Return a .ply file of degree 0: 17 floats a splat, normals of zero."""
    zero = np.zeros(len(splats), np.float32)
    dc = ((splats.rgb.astype(np.float64) - 0.5) / SH_0).astype(np.float32)
    logits = np.clip(splats.opacity_logits, -LARGEST_LOGIT, LARGEST_LOGIT)
    named = [_PLACE, _DC, SCALE, ROT]
    x, colour, scale, rot = (
        dict(zip(names, array.T, strict=True))
        for names, array in zip(named, (splats.means, dc, splats.log_scales, splats.quats), strict=True)
    )
    data = write_ply(x | dict.fromkeys(("nx", "ny", "nz"), zero) | colour | {"opacity": logits} | scale | rot)
    changes = (
        Change.where(Action.LIMITED, "opacity", logits != splats.opacity_logits, f"to logits of {LARGEST_LOGIT:g}"),
        Change.where(Action.LIMITED, "colour", splats.rgb < 0, NO_NEGATIVE_COLOUR),
    )
    return Written(data, changes)
