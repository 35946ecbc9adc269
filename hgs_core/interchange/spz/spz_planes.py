"""The numbers of SPZ files: one plane of bytes per attribute, all splats of it. Facts: github.com/nianticlabs/spz."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change
from hgs_core.interchange.ply.gaussian_ply import harmonics
from hgs_core.interchange.right_up_back import other_way_up, our_rotations, stored_rotations
from hgs_core.interchange.splat_file import opacity_changes
from hgs_core.interchange.splat_properties import SH_0
from hgs_core.interchange.spz.spz_rotations import (
    pack_first_three,
    pack_smallest_three,
    unpack_first_three,
    unpack_smallest_three,
)
from hgs_core.scene.opacities import logits_of_any, opacities_of
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splats import StaticSplats

__all__ = ["DEGREES", "Packed", "Planes", "pack", "unpack", "widths"]

Bytes = NDArray[np.uint8]

DEGREES = (0, 9, 24, 45, 72)
"""Bytes of harmonics by degree."""

FRACTIONAL_BITS = 12
NO_HARMONIC = 128  # the byte of a coefficient of zero
COLOUR_SCALE = 0.15
SCALES = (-10.0, 255 / 16 - 10)  # log-scales that a byte holds


class Planes(NamedTuple):
    """Bytes of all splats [N, width], in the order of the files."""

    positions: Bytes
    opacities: Bytes
    colours: Bytes
    scales: Bytes
    rotations: Bytes
    harmonics: Bytes


class Packed(NamedTuple):
    """Planes, the fractional bits of their positions, and the changes of splats."""

    planes: Planes
    bits: int
    changes: tuple[Change, ...]


def widths(version: int, degree: int) -> tuple[int, ...]:
    """Return the bytes of a splat in each plane."""
    return 9, 1, 3, 3, 3 if version < 3 else 4, DEGREES[degree]


def pack(splats: StaticSplats[Floats], version: int) -> Packed:
    """Return the planes of degree 0; version 2 has coarser rotations in a byte less.

    Raises:
        InputError: a position is too far from the origin for 24 bits.
    """
    largest = float(np.abs(splats.means).max(initial=0.0))
    bits = FRACTIONAL_BITS
    while bits > 0 and largest * 2**bits >= 2**23 - 1:
        bits -= 1
    if largest * 2**bits >= 2**23 - 1:
        raise InputError("splats", f"reach {largest:.3g} from the origin", "SPZ holds less than 8,388,607")
    fixed = np.rint(other_way_up(splats.means) * 2**bits).astype("<i4")
    xyzw = stored_rotations(unit_quaternions(splats.quats))
    planes = Planes(
        fixed.view(np.uint8).reshape(-1, 4)[:, :3].reshape(-1, 9),
        _byte(opacities_of(splats.opacity_logits) * 255)[:, None],
        _byte((splats.rgb - 0.5) / SH_0 * (COLOUR_SCALE * 255) + 127.5),
        _byte((splats.log_scales + 10) * 16),
        pack_smallest_three(xyzw) if version >= 3 else pack_first_three(xyzw),
        np.zeros((len(splats), 0), np.uint8),
    )
    places = other_way_up(fixed / 2.0**bits)
    return Packed(planes, bits, (_moved(splats, places, bits), *_changes(splats, xyzw, planes)))


def _moved(splats: StaticSplats[Floats], places: Doubles, bits: int) -> Change:
    return Change.rounded("position", splats.means, places, f"fixed point, steps of 1/{2**bits:,}")


def _changes(splats: StaticSplats[Floats], xyzw: Doubles, planes: Planes) -> list[Change]:
    decoded = _rotations(planes.rotations)
    decoded *= np.where((decoded * xyzw).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    darkest, brightest = colours = _colour(np.array([0, 255], np.uint8))
    dim = (splats.rgb < darkest) | (splats.rgb > brightest)
    thin = (splats.log_scales < SCALES[0]) | (splats.log_scales > SCALES[1])
    scales = planes.scales / 16.0 - 10
    component_bits = 10 if planes.rotations.shape[1] == 4 else 8
    return [
        *opacity_changes(splats.opacity_logits, planes.opacities[:, 0]),
        Change.where(Action.LIMITED, "colour", dim, f"to {darkest:.2f} to {brightest:.2f}"),
        Change.rounded("colour", np.clip(splats.rgb, *colours), _colour(planes.colours), "8 bits a channel"),
        Change.where(Action.LIMITED, "scale", thin, f"to e^{SCALES[0]:g} to e^{SCALES[1]:.1f}"),
        Change.rounded("scale", np.clip(splats.log_scales, *SCALES), scales, "8 bits of its logarithm"),
        Change.rounded("rotation", xyzw, decoded, f"{component_bits} bits a component"),
    ]


def unpack(planes: Planes, bits: int) -> tuple[StaticSplats[Floats], list[Change]]:
    """Return the splats of planes, and the omissions."""
    wide = np.zeros((len(planes.positions), 3, 4), np.uint8)
    wide[..., 1:] = planes.positions.reshape(-1, 3, 3)  # the sign bit on top
    places = (wide.view("<i4")[..., 0] >> 8) / 2.0**bits
    splats = StaticSplats(
        other_way_up(places).astype(np.float32),
        (planes.scales / 16.0 - 10).astype(np.float32),
        our_rotations(_rotations(planes.rotations)).astype(np.float32),
        logits_of_any(planes.opacities[:, 0] / 255.0),
        _colour(planes.colours).astype(np.float32),
    )
    return splats, [harmonics(planes.harmonics != NO_HARMONIC)] if planes.harmonics.shape[1] else []


def _rotations(packed: Bytes) -> Doubles:
    return unpack_smallest_three(packed) if packed.shape[1] == 4 else unpack_first_three(packed)


def _colour(stored: Bytes) -> Doubles:
    return np.asarray(0.5 + SH_0 * (stored / 255.0 - 0.5) / COLOUR_SCALE)


def _byte(values: Doubles | Floats) -> Bytes:
    return np.asarray(np.clip(np.floor(values + 0.5), 0, 255), np.uint8)
