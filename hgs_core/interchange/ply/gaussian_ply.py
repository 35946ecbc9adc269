"""Point clouds of 3D Gaussian Splatting (Kerbl et al., 2023): .ply with logits, log-scales and spherical harmonics.

World and rotations are ours (OpenCV axes, quaternions w, x, y, z). Colour is 0.5 + SH_0 f_dc, not below 0 when drawn.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.interchange.antialiasing_note import note_of, noted_for_us
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.file_format import NOTHING_KNOWN, Reading, ReadSplats
from hgs_core.interchange.ply.ply_table import Table, left_over, write_ply
from hgs_core.interchange.splat_properties import DC, PLACE, ROT, SCALE, SH_0, read_properties
from hgs_core.scene.splats import StaticSplats

__all__ = ["GAUSSIAN_BYTES", "LARGEST_LOGIT", "NO_NEGATIVE_COLOUR", "gaussian_ply", "gaussian_splats", "harmonics"]

GAUSSIAN_BYTES = 68  # bytes of a splat of degree 0
LARGEST_LOGIT = 30.0  # largest logit written: viewers take the sigmoid
NO_NEGATIVE_COLOUR = "viewers of the format draw none below 0"


def gaussian_splats(path: Path, table: Table, reading: Reading = NOTHING_KNOWN) -> ReadSplats:
    """Return the splats of a table that `read_ply` read from `path`, and the omissions.

    Raises:
        InputError: a property is missing, or may mean one thing or another.
    """
    found = read_properties(path, table, reading)
    rgb = found.colours if found.plain else (0.5 + SH_0 * found.colours).astype(np.float32)
    splats = StaticSplats(found.places, found.log_scales, found.quats, found.logits, rgb)
    changes = [*found.changes, *left_over(table, found.known, ("f_rest_",))]
    rest = [array for name, array in table.items() if name.startswith("f_rest_")]
    if rest:
        changes.append(harmonics(np.stack(rest, axis=1) != 0))
    return ReadSplats(splats, middle=found.middle, changes=tuple(changes))


def harmonics(met: NDArray[np.bool_]) -> Change:
    """Return the change of leaving out the harmonics above degree 0: `met` [N, C] tells which are not zero."""
    degree = round((met.shape[1] / 3 + 1) ** 0.5) - 1
    reason = f"spherical harmonics of degree 1 to {degree}: colours are the same from every direction"
    return Change.where(Action.LEFT_OUT, "view-dependent colour", met, reason)


def gaussian_ply(splats: StaticSplats[Floats], antialiased: bool = False) -> Written:
    """Return a .ply file of degree 0: 17 floats a splat, normals of zero, and a comment on how it is drawn."""
    zero = np.zeros(len(splats), np.float32)
    dc = ((splats.rgb.astype(np.float64) - 0.5) / SH_0).astype(np.float32)
    logits = np.clip(splats.opacity_logits, -LARGEST_LOGIT, LARGEST_LOGIT)
    named = [PLACE, DC, SCALE, ROT]
    x, colour, scale, rot = (
        dict(zip(names, array.T, strict=True))
        for names, array in zip(named, (splats.means, dc, splats.log_scales, splats.quats), strict=True)
    )
    table = x | dict.fromkeys(("nx", "ny", "nz"), zero) | colour | {"opacity": logits} | scale | rot
    note = noted_for_us(antialiased)
    changes = (
        *([] if note is None else [note]),
        Change.where(Action.LIMITED, "opacity", logits != splats.opacity_logits, f"to logits of {LARGEST_LOGIT:g}"),
        Change.where(Action.LIMITED, "colour", splats.rgb < 0, NO_NEGATIVE_COLOUR),
    )
    return Written(write_ply(table, [note_of(antialiased)]), changes)
