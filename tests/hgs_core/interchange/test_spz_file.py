"""SPZ files, packed and unpacked by hand as the format's description has it."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.spz_file import SPZ, read_spz, spz_file
from hgs_core.scene import HybridScene, StaticSplats
from tests.hgs_core.interchange.scenes import Write, axes_of, counted, plain_but

HALF = 2**-0.5
ONE = StaticSplats(*(np.float32([value]) for value in (
    [1, 2, 3], [-2.0, -3.0, -4.0], [0.8, 0.4, -0.4, 0.2], np.log(51 / 204), [0.5, 0.5 + 0.28209479, 0.5])))  # fmt: skip


def nine_bits(value: float) -> int:
    """A sign and nine bits of a share of the root of a half, as the description packs a quaternion's component."""
    return (value < 0) << 9 | int(abs(value) / HALF * 511 + 0.5)


# Right, up, back: our y and z with their signs changed. Of x, y, z, w the last is the largest, and left out.
POSITION = b"".join(int(x * 4096).to_bytes(3, "little", signed=True) for x in (1, -2, -3))
APPEARANCE = bytes([51, 128, 166, 128, 128, 112, 96])  # opacity; colour; (log-scale + 10) * 16
SMALLEST_THREE = struct.pack("<I", 3 << 30 | nine_bits(0.4) << 20 | nine_bits(0.4) << 10 | nine_bits(-0.2))
FIRST_THREE = bytes([int(127.5 + 127.5 * x + 0.5) for x in (0.4, 0.4, -0.2)])


def unpacked(data: bytes) -> tuple[tuple[object, ...], bytes]:
    raw = gzip.decompress(data)
    return struct.unpack_from("<4sII4B", raw), raw[16:]


@pytest.mark.parametrize(("version", "rotation"), [(2, FIRST_THREE), (3, SMALLEST_THREE)])
def test_a_splat_is_the_bytes_of_the_description(written: Write, version: int, rotation: bytes) -> None:
    header, planes = unpacked(spz_file(ONE, version=version).data)
    assert header == (b"NGSP", version, 1, 0, 12, 0, 0)
    assert planes == POSITION + APPEARANCE + rotation
    packed = struct.pack("<4sII4B", b"NGSP", version, 1, 0, 12, 0, 0) + POSITION + APPEARANCE + rotation
    found, antialiased, changes = read_spz(written("x.spz", gzip.compress(packed)))
    assert (antialiased, changes) == (False, [])
    for name, array in ONE.items():
        np.testing.assert_allclose(getattr(found, name), array, atol=0.008, err_msg=name)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("largest", range(4))
@pytest.mark.parametrize("sign", [1, -1])
def test_any_component_of_a_rotation_may_be_the_largest_and_negative(
    written: Write, version: int, largest: int, sign: int
) -> None:
    quat = np.array([[0.3, -0.2, 0.1, -0.15]], np.float32)
    quat[0, largest] = sign * 0.9
    given = StaticSplats(ONE.means, ONE.log_scales, quat, ONE.opacity_logits, ONE.rgb)
    found = read_spz(written("x.spz", spz_file(given, version=version).data))[0]
    np.testing.assert_allclose(axes_of(found.quats), axes_of(quat), atol=0.003 if version == 3 else 0.04)


@pytest.mark.parametrize("antialiased", [False, True])
def test_what_is_written_is_read_within_the_formats_steps(
    still: HybridScene[np.ndarray], written: Write, antialiased: bool
) -> None:
    found, drawn_so, _ = read_spz(written("x.spz", spz_file(still.static, antialiased=antialiased).data))
    assert drawn_so == antialiased
    np.testing.assert_allclose(found.means, still.static.means, atol=0.5 / 4096 + 1e-6)
    np.testing.assert_allclose(found.log_scales, still.static.log_scales, atol=0.5 / 16 + 1e-6)
    np.testing.assert_allclose(found.rgb, still.static.rgb, atol=0.5 / 255 / 0.15 * 0.2821 + 1e-6)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(still.static.quats), atol=0.006)


def test_a_file_of_version_2_has_a_byte_less_a_splat(still: HybridScene[np.ndarray]) -> None:
    raw = [len(gzip.decompress(spz_file(still.static, version=version).data)) for version in (2, 3)]
    assert raw == [16 + 50 * 19, 16 + 50 * 20]


def test_fewer_fractional_bits_are_taken_far_from_the_origin(still: HybridScene[np.ndarray], written: Write) -> None:
    far = StaticSplats(still.static.means * 1e4, *(a for _, a in list(still.static.items())[1:]))
    assert np.abs(far.means).max() * 2**7 > 2**23 > np.abs(far.means).max() * 2**6
    data = spz_file(far).data
    assert unpacked(data)[0][4] == 6
    np.testing.assert_allclose(read_spz(written("x.spz", data))[0].means, far.means, atol=0.5 / 64)


def test_a_place_beyond_24_bits_is_refused() -> None:
    with pytest.raises(InputError, match=r"splats: reach 9e\+06 from the origin; SPZ holds less than 8,388,607"):
        spz_file(plain_but(means={3: -9e6}).static)


def test_harmonics_are_left_out_and_those_that_are_not_zero_counted(written: Write) -> None:
    raw = bytearray(gzip.decompress(spz_file(plain_but().static).data))
    raw[12] = 1  # the degree
    harmonics = np.full((20, 9), 128, np.uint8)
    harmonics[:7, 3] = 90
    changes = read_spz(written("x.spz", gzip.compress(bytes(raw) + harmonics.tobytes())))[2]
    assert counted(changes) == {("left out", "view-dependent colour"): 7}


def test_what_steps_and_ranges_change_is_counted_by_kind() -> None:
    given = plain_but(
        means={0: 1e-5}, rgb={1: -3.0, 2: 3.0, 3: 0.3333}, opacity_logits={4: -9.0, 5: 0.77},
        log_scales={7: -100.0, 8: 90.0, 9: -2.01},
    ).static  # fmt: skip
    found = {what: count for what, count in counted(spz_file(given).changes).items() if count}
    assert found == {
        ("rounded", "position"): 1, ("limited", "scale"): 2, ("rounded", "scale"): 1, ("limited", "colour"): 2,
        ("rounded", "colour"): 20, ("rounded", "opacity"): 1, ("replaced", "opacity"): 1,
    }  # fmt: skip


def test_a_quaternion_of_the_opposite_sign_is_no_change_of_rotation() -> None:
    given = plain_but(quats=dict.fromkeys(range(20), -1.0)).static
    assert counted(spz_file(given).changes)["rounded", "rotation"] == 0


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"1234", "is not a gzipped SPZ file"),
        (gzip.compress(b"1234" * 99)[:-9], "is not a gzipped SPZ file"),
        (gzip.compress(b"1234"), "holds 4 bytes without an SPZ header"),
        (gzip.compress(b"PGSN" + bytes(12)), "holds 16 bytes without an SPZ header"),
        (gzip.compress(b"NGSP\x04\0\0\0" + bytes(8)), "is of version 4"),
        (gzip.compress(b"NGSP\x03\0\0\0\0\0\0\0\x05\x0c\0\0"), "is of version 3, SH degree 5"),
        (gzip.compress(b"NGSP\x03\0\0\0\0\0\0\0\0\x0c\x02\0"), "12 fractional bits, flags 2"),
        (gzip.compress(b"NGSP\x02\0\0\0\x05\0\0\0\0\x0c\0\0"), "has 16 bytes, 5 splats need 111"),
        (None, "is not a gzipped SPZ file"),
    ],
)
def test_a_file_that_is_none_is_named(tmp_path: Path, data: bytes | None, problem: str) -> None:
    path = tmp_path / "x.spz"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_spz(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert problem in str(caught.value)


def test_the_format_says_how_splats_are_drawn(written: Write) -> None:
    assert SPZ.read is not None
    assert SPZ.write_still is not None
    assert SPZ.says_antialiased
    assert SPZ.read(written("x.spz", SPZ.write_still(ONE, True).data)).antialiased
