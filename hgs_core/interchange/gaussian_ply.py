"""Point clouds of 3D Gaussian Splatting (Kerbl et al., 2023): .ply with logits, log-scales and spherical harmonics.

World and rotations are ours (OpenCV axes, quaternions w, x, y, z). Colour is 0.5 + SH_0 f_dc, not below 0 when drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.interchange.ply_table import columns, write_ply
from hgs_core.scene.splats import StaticSplats

__all__ = ["ROT", "SCALE", "SH_0", "gaussian_ply", "gaussian_splats"]

SH_0 = 0.28209479177387814
"""The constant spherical harmonic, 1 / (2 sqrt(pi))."""

SCALE = ("scale_0", "scale_1", "scale_2")
ROT = ("rot_0", "rot_1", "rot_2", "rot_3")
_DC = ("f_dc_0", "f_dc_1", "f_dc_2")

Floats = NDArray[np.float32]


def gaussian_splats(path: Path, table: Mapping[str, Floats]) -> tuple[StaticSplats[Floats], list[str]]:
    """Return the splats of a table that `read_ply` read from `path`, and notes on what was left out.

    Raises:
        InputError: a property is missing.
    """
    splats = StaticSplats(
        columns(path, table, ("x", "y", "z")),
        columns(path, table, SCALE),
        columns(path, table, ROT),
        columns(path, table, ("opacity",))[:, 0],
        np.maximum(0.5 + SH_0 * columns(path, table, _DC), 0).astype(np.float32),
    )
    higher = sum(name.startswith("f_rest_") for name in table)
    if not higher:
        return splats, []
    degree = round((higher / 3 + 1) ** 0.5) - 1
    return splats, [f"spherical harmonics of degree 1 to {degree} left out: colours are the same from every direction"]


def gaussian_ply(splats: StaticSplats[Floats]) -> bytes:
    """Return a .ply file of degree 0: 17 floats a splat, normals of zero."""
    zero = np.zeros(len(splats), np.float32)
    dc = ((splats.rgb.astype(np.float64) - 0.5) / SH_0).astype(np.float32)
    # Viewers take the sigmoid; an infinite logit is an opacity of 0 or 1.
    logits = np.clip(splats.opacity_logits, -30, 30)
    named = [("x", "y", "z"), _DC, SCALE, ROT]
    x, colour, scale, rot = (
        dict(zip(names, array.T, strict=True))
        for names, array in zip(named, (splats.means, dc, splats.log_scales, splats.quats), strict=True)
    )
    return write_ply(x | dict.fromkeys(("nx", "ny", "nz"), zero) | colour | {"opacity": logits} | scale | rot)
