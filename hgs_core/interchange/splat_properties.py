"""The properties of splats in tables with the column names of several programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.activated_values import as_stored
from hgs_core.interchange.changes import Action, Change
from hgs_core.interchange.far_places import middle_if_far, moved
from hgs_core.interchange.file_format import Reading
from hgs_core.interchange.ply.ply_table import Table, columns, exact_columns, rounded
from hgs_core.interchange.smoothing_filter import FILTER, fused

__all__ = ["DC", "PLACE", "ROT", "SCALE", "SH_0", "Properties", "read_properties"]

SH_0 = 0.28209479177387814
"""The constant spherical harmonic, 1 / (2 sqrt(pi))."""

PLACE = ("x", "y", "z")
SCALE = ("scale_0", "scale_1", "scale_2")
ROT = ("rot_0", "rot_1", "rot_2", "rot_3")
DC = ("f_dc_0", "f_dc_1", "f_dc_2")
FLAT = float(np.log(1e-6))  # log-scale of an axis that surfels do not have
_RGB = (("red", "green", "blue"), ("r", "g", "b"))
_SCALES = (SCALE, ("scale_x", "scale_y", "scale_z"))
_TURNS = (ROT, ("rot_w", "rot_x", "rot_y", "rot_z"), ("qw", "qx", "qy", "qz"))
_OPACITY = ("opacity", "alpha")


@dataclass(frozen=True)
class Properties:
    """The properties common to both kinds of point clouds."""

    places: Floats  # [N, 3], less `middle`
    log_scales: Floats  # [N, 3]
    quats: Floats  # [N, 4]
    logits: Floats  # [N]
    colours: Floats  # [N, 3], harmonics of degree 0, or rgb where `plain` holds
    plain: bool
    middle: Doubles | None
    known: tuple[str, ...]  # columns that were read
    changes: tuple[Change, ...]


def read_properties(path: Path, table: Table, reading: Reading) -> Properties:
    """Return the columns of a table under any known name.

    Surfels, which have two scales, become flat; the widths of Mip-Splatting's filter are fused; scales and opacities
    become logarithms and logits; places far from the origin are moved there.

    Raises:
        InputError: a property is missing, or may mean one thing or another.
    """
    changes: list[Change] = []
    scale = _first_of(table, _SCALES)
    surfel = scale[:2] == SCALE[:2] and SCALE[0] in table and SCALE[1] in table and SCALE[2] not in table
    scale = scale[:2] if surfel else scale
    rot, opacity = _first_of(table, _TURNS), _first_of(table, tuple((name,) for name in _OPACITY))
    exact = exact_columns(path, table, PLACE)
    if scale[0] not in table and opacity[0] not in table:
        cure = "give the file that a training of splats wrote, as point_cloud/iteration_30000/point_cloud.ply"
        raise InputError(path, "holds points, not splats: they have no sizes and no opacities", cure)
    scales, opacities = exact_columns(path, table, scale), exact_columns(path, table, opacity)[:, 0]
    quats = columns(path, table, rot)
    colours, names, plain = _colours(path, table)
    if table[opacity[0]].dtype.kind in "iu":
        opacities = opacities / np.iinfo(table[opacity[0]].dtype).max
    kept = np.linalg.norm(quats.astype(np.float64), axis=1) > 0  # rows of zeros tell nothing of ranges
    stored = as_stored(path, scales, opacities, exact, reading.activated, kept)
    log_scales, logits = stored.log_scales, stored.logits
    changes += stored.changes
    if surfel:
        log_scales = np.concatenate([log_scales, np.full((len(log_scales), 1), FLAT, np.float32)], axis=1)
        reason = "by 1e-6: the file has two scales, of flat splats (2DGS)"
        changes.append(Change(Action.REPLACED, "thickness", len(scales), len(scales), reason))
    known = [*PLACE, *scale, *rot, *opacity, *names]
    if FILTER in table:
        widths = exact_columns(path, table, (FILTER,))[:, 0]
        log_scales, logits, change = fused(log_scales, logits, widths)
        changes.append(change)
        known.append(FILTER)
    middle = reading.middle
    if middle is None and reading.centred:
        middle = middle_if_far(exact)
        changes += [] if middle is None else [moved(middle)]
    near = exact if middle is None else exact - middle
    changes.append(rounded(table, near, tuple(name for name in known if name not in PLACE)))
    with np.errstate(over="ignore"):
        places = near.astype(np.float32)
    return Properties(places, log_scales, quats, logits, colours, plain, middle, tuple(known), tuple(changes))


def _first_of(table: Table, names: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Return the first of some sets of names that the table has all of, else the first set."""
    return next((one for one in names if all(name in table for name in one)), names[0])


def _colours(path: Path, table: Table) -> tuple[Floats, tuple[str, ...], bool]:
    """Return colours [N, 3], the columns that hold them, and whether they are rgb."""
    names = next((one for one in _RGB if all(name in table for name in one)), None)
    if names is None or any(name in table for name in DC):
        return columns(path, table, DC), DC, False
    largest = 1.0
    kinds = {table[name].dtype for name in names}
    if all(kind.kind in "iu" for kind in kinds):
        largest = float(max(np.iinfo(kind).max for kind in kinds))
    rgb = exact_columns(path, table, names)
    if largest == 1.0 and np.nanmax(rgb, initial=0.0) > 1.0:
        if np.nanmax(rgb, initial=0.0) > 255:
            raise InputError(path, f"has {', '.join(names)} beyond 255", "export it again")
        largest = 255.0
    return (rgb / largest).astype(np.float32), names, True
