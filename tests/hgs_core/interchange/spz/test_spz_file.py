"""SPZ files, packed and unpacked by hand as the format's description has it."""

from __future__ import annotations

import gzip
import itertools
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import zstandard

from hgs_core.base.errors import InputError
from hgs_core.interchange.file_format import NOTHING_KNOWN
from hgs_core.interchange.spz.spz_file import SPZ, read_spz, spz_file
from hgs_core.scene import HybridScene, StaticSplats
from hgs_core.scene.opacities import opacities_of
from tests.conftest import REPOSITORY
from tests.hgs_core.interchange.scenes import Write, axes_of, counted, plain_but, statics

HALF = 2**-0.5
ONE = StaticSplats(
    *(
        np.float32([value])
        for value in (
            [1, 2, 3],
            [-2.0, -3.0, -4.0],
            [0.8, 0.4, -0.4, 0.2],
            np.log(51 / 204),
            [0.5, 0.5 + 0.28209479, 0.5],
        )
    )
)


def gzipped(data: bytes) -> bytes:
    return gzip.compress(data, mtime=0)  # names of tests do not tell the time


def nine_bits(value: float) -> int:
    """A sign and nine bits of a share of the root of a half, as the description packs a quaternion's component."""
    return (value < 0) << 9 | int(abs(value) / HALF * 511 + 0.5)


# Right, up, back: our y and z with their signs changed. Of x, y, z, w the last is the largest, and left out.
POSITION = b"".join(int(x * 4096).to_bytes(3, "little", signed=True) for x in (1, -2, -3))
APPEARANCE = bytes([51, 128, 166, 128, 128, 112, 96])  # opacity; colour; (log-scale + 10) * 16
SMALLEST_THREE = struct.pack("<I", 3 << 30 | nine_bits(0.4) << 20 | nine_bits(0.4) << 10 | nine_bits(-0.2))
FIRST_THREE = bytes([int(127.5 + 127.5 * x + 0.5) for x in (0.4, 0.4, -0.2)])


VECTORS = REPOSITORY / "tests" / "vectors" / "interchange"
PLANES = (POSITION, APPEARANCE[:1], APPEARANCE[1:4], APPEARANCE[4:], SMALLEST_THREE)


def unpacked(data: bytes) -> tuple[tuple[object, ...], bytes]:
    raw = gzip.decompress(data)
    return struct.unpack_from("<4sII4B", raw), raw[16:]


def latest(planes: Sequence[bytes], count: int = 1, flags: int = 0, records: bytes = b"", more: bytes = b"") -> bytes:
    """A file of version 4: header of 32 bytes, records, table of sizes, planes of zstd, which may have too much."""
    short = [zstandard.compress(plane + more) for plane in planes]
    header = struct.pack("<4sII4BI12x", b"NGSP", 4, count, 0, 12, flags, len(planes), 32 + len(records))
    table = b"".join(struct.pack("<QQ", len(a), len(b)) for a, b in zip(short, planes, strict=True))
    return header + records + table + b"".join(short)


@pytest.mark.parametrize(("version", "rotation"), [(2, FIRST_THREE), (3, SMALLEST_THREE)])
def test_a_splat_is_the_bytes_of_the_description(written: Write, version: int, rotation: bytes) -> None:
    header, planes = unpacked(spz_file(ONE, version=version).data)
    assert header == (b"NGSP", version, 1, 0, 12, 0, 0)
    assert planes == POSITION + APPEARANCE + rotation
    packed = struct.pack("<4sII4B", b"NGSP", version, 1, 0, 12, 0, 0) + POSITION + APPEARANCE + rotation
    found, antialiased, changes = read_spz(written("x.spz", gzipped(packed)))
    assert (antialiased, changes) == (False, [])
    for name, array in ONE.items():
        np.testing.assert_allclose(getattr(found, name), array, atol=0.008, err_msg=name)


@pytest.mark.parametrize("version", [2, 3, 4])
@pytest.mark.parametrize("largest", range(4))
@pytest.mark.parametrize("sign", [1, -1])
def test_any_component_of_a_rotation_may_be_the_largest_and_negative(
    written: Write, version: int, largest: int, sign: int
) -> None:
    quat = np.array([[0.3, -0.2, 0.1, -0.15]], np.float32)
    quat[0, largest] = sign * 0.9
    given = StaticSplats(ONE.means, ONE.log_scales, quat, ONE.opacity_logits, ONE.rgb)
    found = read_spz(written("x.spz", spz_file(given, version=version).data))[0]
    np.testing.assert_allclose(axes_of(found.quats), axes_of(quat), atol=0.04 if version == 2 else 0.003)


def test_a_file_of_version_4_is_the_bytes_of_the_description(written: Write) -> None:
    """zstd may make other bytes of a plane than the same library's default, so that planes are compared unpacked."""
    data = spz_file(ONE, version=4, antialiased=True).data
    assert struct.unpack_from("<4sII4BI12s", data) == (b"NGSP", 4, 1, 0, 12, 1, 5, 32, bytes(12))
    sizes = [struct.unpack_from("<QQ", data, 32 + 16 * i) for i in range(5)]
    ends = np.cumsum([32 + 16 * 5, *(short for short, _ in sizes)])
    parts = [zstandard.decompress(data[a:b]) for a, b in itertools.pairwise(ends)]
    assert (parts, ends[-1]) == ([*PLANES], len(data))
    assert [size for _, size in sizes] == [len(plane) for plane in PLANES]
    found = read_spz(written("x.spz", latest(PLANES)))[0]
    for name, array in ONE.items():
        np.testing.assert_allclose(getattr(found, name), array, atol=0.008, err_msg=name)


def test_a_file_of_version_4_of_another_program_is_read() -> None:
    """splat-transform 2.7.1, which has the library of the format's makers, wrote these splats with harmonics."""
    found, antialiased, changes = read_spz(VECTORS / "splat_transform.spz")
    ours = statics(12, 7)
    np.testing.assert_allclose(found.means, ours.means, atol=0.5 / 4096 + 1e-6)
    np.testing.assert_allclose(found.log_scales, ours.log_scales, atol=0.5 / 16 + 1e-6)
    np.testing.assert_allclose(found.rgb, ours.rgb, atol=0.5 / 255 / 0.15 * 0.2821 + 1e-6)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(ours.quats), atol=0.006)
    np.testing.assert_allclose(opacities_of(found.opacity_logits), opacities_of(ours.opacity_logits), atol=0.5 / 255)
    assert (antialiased, counted(changes)) == (False, {("left out", "view-dependent colour"): 8})


RECORDS = struct.pack("<III", 0xADBE0003, 4, 4) + struct.pack("<II3f", 0xADBE0002, 12, 0, 1, 2)


@pytest.mark.parametrize("version", [3, 4])
def test_records_of_extensions_are_told_and_passed_over(written: Write, version: int) -> None:
    records = RECORDS + struct.pack("<IIB", 0x12340001, 1, 9)
    data = latest(PLANES, flags=2, records=records)
    if version == 3:
        data = gzipped(struct.pack("<4sII4B", b"NGSP", 3, 1, 0, 12, 2, 0) + b"".join(PLANES) + records)
    found, _, changes = read_spz(written("x.spz", data))
    assert found.means[0].tolist() == [1, 2, 3]
    assert [change.what for change in changes] == ["camera's limits", "extension 0x12340001"]


def test_other_axes_than_right_up_back_are_refused(written: Write) -> None:
    data = latest(PLANES, flags=2, records=struct.pack("<III", 0xADBE0003, 4, 7))
    with pytest.raises(InputError, match=r"is in axes other than right, up, back \(number 7 of SPZ_ADOBE_coordinate"):
        read_spz(written("x.spz", data))


def test_a_file_without_splats_has_no_planes(written: Write) -> None:
    assert len(read_spz(written("x.spz", spz_file(ONE.take(slice(0, 0)), version=4).data))[0]) == 0


@pytest.mark.parametrize("version", [2, 3, 4])
@pytest.mark.parametrize("antialiased", [False, True])
def test_what_is_written_is_read_within_the_formats_steps(
    still: HybridScene[np.ndarray], written: Write, antialiased: bool, version: int
) -> None:
    file = written("x.spz", spz_file(still.static, antialiased=antialiased, version=version).data)
    found, drawn_so, _ = read_spz(file)
    assert drawn_so == antialiased
    np.testing.assert_allclose(found.means, still.static.means, atol=0.5 / 4096 + 1e-6)
    np.testing.assert_allclose(found.log_scales, still.static.log_scales, atol=0.5 / 16 + 1e-6)
    np.testing.assert_allclose(found.rgb, still.static.rgb, atol=0.5 / 255 / 0.15 * 0.2821 + 1e-6)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(still.static.quats), atol=0.25 if version == 2 else 0.006)


def test_a_file_of_version_2_has_a_byte_less_a_splat(still: HybridScene[np.ndarray]) -> None:
    raw = [len(gzip.decompress(spz_file(still.static, version=version).data)) for version in (2, 3)]
    assert raw == [16 + 50 * 19, 16 + 50 * 20]


def test_fewer_fractional_bits_are_taken_far_from_the_origin(still: HybridScene[np.ndarray], written: Write) -> None:
    far = StaticSplats(still.static.means * 1e4, *(a for _, a in list(still.static.items())[1:]))
    assert np.abs(far.means).max() * 2**7 > 2**23 > np.abs(far.means).max() * 2**6
    data = spz_file(far, version=3).data
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
    changes = read_spz(written("x.spz", gzipped(bytes(raw) + harmonics.tobytes())))[2]
    assert counted(changes) == {("left out", "view-dependent colour"): 7}


def test_what_steps_and_ranges_change_is_counted_by_kind() -> None:
    given = plain_but(
        means={0: 1e-5},
        rgb={1: -3.0, 2: 3.0, 3: 0.3333},
        opacity_logits={4: -9.0, 5: 0.77},
        log_scales={7: -100.0, 8: 90.0, 9: -2.01},
    ).static
    found = {what: count for what, count in counted(spz_file(given).changes).items() if count}
    assert found == {
        ("rounded", "position"): 1,
        ("limited", "scale"): 2,
        ("rounded", "scale"): 1,
        ("limited", "colour"): 2,
        ("rounded", "colour"): 20,
        ("rounded", "opacity"): 1,
        ("replaced", "opacity"): 1,
    }


def test_a_quaternion_of_the_opposite_sign_is_no_change_of_rotation() -> None:
    given = plain_but(quats=dict.fromkeys(range(20), -1.0)).static
    assert counted(spz_file(given).changes)["rounded", "rotation"] == 0


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"1234", "is not an SPZ file"),
        (gzipped(b"1234" * 99)[:-9], "is not an SPZ file"),
        (gzipped(b"1234"), "holds 4 bytes without an SPZ header"),
        (gzipped(b"PGSN" + bytes(12)), "holds 16 bytes without an SPZ header"),
        (gzipped(b"NGSP\x04\0\0\0" + bytes(8)), "is of version 4"),
        (gzipped(b"NGSP\x03\0\0\0\0\0\0\0\x05\x0c\0\0"), "is of version 3, SH degree 5"),
        (gzipped(b"NGSP\x03\0\0\0\0\0\0\0\0\x18\0\0"), "is of version 3, SH degree 0, 24 fractional bits"),
        (gzipped(b"NGSP\x03\0\0\0\0\0\0\0\0\x0c\0\0??"), "has 18 bytes, 0 splats need 16"),
        (gzipped(b"NGSP\x03\0\0\0\xff\xff\xff\xff\0\x0c\0\0"), "claims 4,294,967,295 splats, which are more"),
        (b"NGSP\x04\0\0\0", "holds 8 bytes without an SPZ header"),
        (b"NGSP\x05\0\0\0" + latest(PLANES)[8:], "is of version 5"),
        (b"NGSP\x03\0\0\0" + latest(PLANES)[8:], "is of version 3"),
        (latest(PLANES)[:15] + b"\4" + latest(PLANES)[16:], "has 4 planes, and their table at byte 32"),
        (latest(PLANES)[:16] + b"\xff" + latest(PLANES)[17:], "has 5 planes, and their table at byte 255"),
        (latest(PLANES)[:16] + b"\x10" + latest(PLANES)[17:], "has 5 planes, and their table at byte 16"),
        (latest(PLANES)[:-1], "has a plane of 4 bytes in"),
        (latest(PLANES, count=2), "has a plane of 9 bytes in"),
        (latest(PLANES, more=b"?"), "holds a plane that is not of 9 bytes"),
        (latest(PLANES)[:112] + b"?" + latest(PLANES)[113:], "holds a damaged plane"),
        (gzipped(b"NGSP\x02\0\0\0\x05\0\0\0\0\x0c\0\0"), "has 16 bytes, 5 splats need 111"),
        (None, "cannot be read"),
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
    assert SPZ.read(written("x.spz", SPZ.write_still(ONE, True).data), NOTHING_KNOWN).antialiased
    for write in SPZ.versions.values():
        assert SPZ.read(written("x.spz", write(ONE, True).data), NOTHING_KNOWN).antialiased
    assert unpacked(SPZ.write_still(ONE, False).data)[0][1] == 3
