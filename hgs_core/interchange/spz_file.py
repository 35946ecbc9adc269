"""SPZ files (Niantic, versions 2 and 3): static splats in fixed point, 19 or 20 bytes each, gzipped as a whole.

A 16-byte header (magic "NGSP", version, count, SH degree, fractional bits, flags) and one plane after another:
positions (24 bits), opacity, colour, log-scale (8 bits), rotation, harmonics. Axes are right, up, back: y and z of ours
with their signs changed. Facts from the format's README (github.com/nianticlabs/spz).
"""

from __future__ import annotations

import gzip
import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.file_format import FileFormat, ReadSplats
from hgs_core.interchange.gaussian_ply import SH_0, harmonics
from hgs_core.interchange.splat_file import opacity_changes
from hgs_core.scene.opacities import logits_of, opacities_of
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splats import StaticSplats

__all__ = ["SPZ", "read_spz", "spz_file"]

HEADER = struct.Struct("<4sII4B")
MAGIC = b"NGSP"
FRACTIONAL_BITS = 12
ANTIALIASED, EXTENSIONS = 1, 2  # flags
HARMONICS = (0, 9, 24, 45, 72)  # bytes by degree
NO_HARMONIC = 128  # the byte of a coefficient of zero
COLOUR_SCALE = 0.15
LARGEST = 1 << 28  # bytes of a file once it is unpacked
FLIP = np.array([1.0, -1.0, -1.0])  # between our axes and right, up, back
LEAST_OPACITY = 1e-6


def spz_file(splats: StaticSplats[Floats], *, antialiased: bool = False, version: int = 3) -> Written:
    """Return an SPZ file of degree 0; version 2 has coarser rotations in a byte less.

    Raises:
        InputError: a position is too far from the origin for 24 bits.
    """
    largest = float(np.abs(splats.means).max(initial=0.0))
    bits = FRACTIONAL_BITS
    while bits > 0 and largest * 2**bits >= 2**23 - 1:
        bits -= 1
    if largest * 2**bits >= 2**23 - 1:
        raise InputError("splats", f"reach {largest:.3g} from the origin", "SPZ holds less than 8,388,607")
    fixed = np.rint(splats.means * FLIP * 2**bits).astype("<i4")
    opacity = opacities_of(splats.opacity_logits)
    harmonic = (splats.rgb - 0.5) / SH_0
    quats = unit_quaternions(splats.quats)
    xyzw = np.concatenate([quats[:, 1:] * FLIP, quats[:, :1]], axis=1)
    shares, scales = _byte(opacity * 255), _byte((splats.log_scales + 10) * 16)
    colours = _byte(harmonic * (COLOUR_SCALE * 255) + 127.5)
    rotations = _smallest_three(xyzw) if version >= 3 else _first_three(xyzw)
    planes = [fixed.view(np.uint8).reshape(-1, 4)[:, :3], shares, colours, scales, rotations]
    flags = ANTIALIASED if antialiased else 0
    header = HEADER.pack(MAGIC, version, len(splats), 0, bits, flags, 0)
    data = gzip.compress(header + b"".join(plane.tobytes() for plane in planes), 9, mtime=0)
    decoded = _largest_made_good(rotations) if version >= 3 else _with_w(rotations / 127.5 - 1)
    decoded *= np.where((decoded * xyzw).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    scale_range, colour_range = (-10.0, 255 / 16 - 10), _colour(np.array([0, 255], np.uint8))
    darkest, brightest = colour_range
    dim = (splats.rgb < darkest) | (splats.rgb > brightest)
    thin = (splats.log_scales < scale_range[0]) | (splats.log_scales > scale_range[1])
    places = fixed / 2.0**bits * FLIP
    changes = (
        Change.rounded("position", splats.means, places, f"fixed point, steps of 1/{2**bits:,}"),
        *opacity_changes(splats.opacity_logits, shares),
        Change.where(Action.LIMITED, "colour", dim, f"to {darkest:.2f} to {brightest:.2f}"),
        Change.rounded("colour", np.clip(splats.rgb, *colour_range), _colour(colours), "8 bits a channel"),
        Change.where(Action.LIMITED, "scale", thin, f"to e^{scale_range[0]:g} to e^{scale_range[1]:.1f}"),
        Change.rounded(
            "scale", np.clip(splats.log_scales, *scale_range), scales / 16.0 - 10, "8 bits of its logarithm"
        ),
        Change.rounded("rotation", xyzw, decoded, f"{10 if version >= 3 else 8} bits a component"),
    )
    return Written(data, changes)


def read_spz(path: Path) -> tuple[StaticSplats[Floats], bool, list[Change]]:
    """Read an SPZ file; returns the splats, whether they were trained antialiased, and what was left out.

    Raises:
        InputError: the file is missing, damaged, or of another version.
    """
    try:
        with gzip.open(path) as file:
            data = file.read(LARGEST + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(path, f"is not a gzipped SPZ file ({error})", "give an SPZ file of version 2 or 3") from error
    if len(data) < HEADER.size or len(data) > LARGEST or data[:4] != MAGIC:
        raise InputError(path, f"holds {len(data)} bytes without an SPZ header", "give an SPZ file of version 2 or 3")
    _, version, count, degree, bits, flags, _ = HEADER.unpack_from(data)
    if version not in (2, 3) or degree >= len(HARMONICS) or bits > 23 or flags & EXTENSIONS:
        raise InputError(
            path, f"is of version {version}, SH degree {degree}, {bits} fractional bits, flags {flags}",
            "save it as version 2 or 3 without extensions",
        )  # fmt: skip
    widths = (9, 1, 3, 3, 4 if version == 3 else 3, HARMONICS[degree])
    if len(data) != HEADER.size + count * sum(widths):
        raise InputError(path, f"has {len(data)} bytes, {count} splats need {HEADER.size + count * sum(widths)}")
    planes, at = [], HEADER.size
    for width in widths:
        planes.append(np.frombuffer(data, np.uint8, count * width, at).reshape(count, width))
        at += count * width
    position, opacity, colour, scale, rotation, higher = planes
    wide = np.zeros((count, 3, 4), np.uint8)
    wide[..., 1:] = position.reshape(count, 3, 3)  # the sign bit on top
    means = (wide.view("<i4")[..., 0] >> 8) / 2.0**bits * FLIP
    xyzw = _largest_made_good(rotation) if version == 3 else _with_w(rotation / 127.5 - 1)
    share = np.clip(opacity[:, 0] / 255.0, LEAST_OPACITY, 1 - LEAST_OPACITY)
    splats = StaticSplats(
        means.astype(np.float32),
        (scale / 16.0 - 10).astype(np.float32),
        np.concatenate([xyzw[:, 3:], xyzw[:, :3] * FLIP], axis=1).astype(np.float32),
        logits_of(share),
        _colour(colour).astype(np.float32),
    )
    return splats, bool(flags & ANTIALIASED), [harmonics(higher != NO_HARMONIC)] if degree else []


def _colour(stored: NDArray[np.uint8]) -> Doubles:
    return np.asarray(0.5 + SH_0 * (stored / 255.0 - 0.5) / COLOUR_SCALE)


def _byte(values: Doubles | Floats) -> NDArray[np.uint8]:
    return np.asarray(np.clip(np.floor(values + 0.5), 0, 255), np.uint8)


def _first_three(xyzw: Doubles) -> NDArray[np.uint8]:
    return _byte(xyzw[:, :3] * np.where(xyzw[:, 3:] < 0, -127.5, 127.5) + 127.5)


def _with_w(vector: Doubles) -> Doubles:
    w = np.sqrt(np.maximum(0.0, 1 - (vector**2).sum(axis=1, keepdims=True)))
    return np.concatenate([vector, w], axis=1)


def _smallest_three(xyzw: Doubles) -> NDArray[np.uint8]:
    """Pack unit quaternions [N, 4]: two bits name the largest component, the others have a sign and nine bits."""
    rows = np.arange(len(xyzw))
    largest = np.abs(xyzw).argmax(axis=1)
    signed = xyzw * np.where(xyzw[rows, largest] < 0, -1.0, 1.0)[:, None]
    packed = largest.astype(np.uint32)
    for component in range(4):
        number = (np.abs(signed[:, component]) * (511 * 2**0.5) + 0.5).astype(np.uint32)
        number |= (signed[:, component] < 0).astype(np.uint32) << np.uint32(9)
        packed = np.where(component == largest, packed, packed << np.uint32(10) | number)
    return np.asarray(packed, "<u4").view(np.uint8).reshape(-1, 4)


def _largest_made_good(rotation: NDArray[np.uint8]) -> Doubles:
    packed = np.ascontiguousarray(rotation).view("<u4")[:, 0]
    largest = (packed >> np.uint32(30)).astype(np.intp)
    rest = packed.copy()
    xyzw = np.zeros((len(packed), 4))
    for component in (3, 2, 1, 0):
        stored = component != largest
        value = (rest & np.uint32(511)) / (511 * 2**0.5)
        xyzw[:, component] = np.where(stored, np.where(rest & np.uint32(512), -value, value), 0.0)
        rest = np.where(stored, rest >> np.uint32(10), rest)
    xyzw[np.arange(len(packed)), largest] = np.sqrt(np.maximum(0.0, 1 - (xyzw**2).sum(axis=1)))
    return xyzw


def _read(path: Path) -> ReadSplats:
    splats, antialiased, changes = read_spz(path)
    return ReadSplats(splats, antialiased=antialiased, changes=tuple(changes))


SPZ = FileFormat(
    ".spz",
    read=_read,
    write_still=lambda splats, antialiased: spz_file(splats, antialiased=antialiased),
    says_antialiased=True,
)
