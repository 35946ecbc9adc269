"""Rows of .splat files, packed and unpacked by hand."""

from __future__ import annotations

import dataclasses
import struct
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.splat_file import SPLAT, opacity_changes, read_splat, rgba_bytes, splat_file
from hgs_core.scene import HybridScene, StaticSplats
from tests.hgs_core.interchange.scenes import Write, axes_of, counted, plain, plain_but, statics

ROW = struct.Struct("<3f3f4B4B")


def test_a_splat_is_32_bytes_of_place_deviations_colour_and_rotation() -> None:
    """Our axes are the format's, so that a mirrored one would be seen here."""
    given = StaticSplats(
        *(
            np.float32([value])
            for value in ([1, 2, 3], np.log([0.5, 0.25, 0.125]), [2.0, 0, -2.0, 0], np.log(51 / 204), [0, 0.2, 1.0])
        )
    )
    (row,) = ROW.iter_unpack(splat_file(given).data)
    assert row[:3] == (1, 2, 3)
    assert row[3:6] == pytest.approx((0.5, 0.25, 0.125))
    assert row[6:10] == (0, 51, 255, 51)
    assert row[10:] == (128 + 91, 128, 128 - 91, 128)  # 128 / sqrt 2 is 90.5


def test_a_row_made_by_hand_is_read(written: Write) -> None:
    data = ROW.pack(1, 2, 3, 0.5, 0.25, 0.125, 0, 51, 255, 51, 128, 255, 128, 1)
    found = read_splat(written("x.splat", data)).static
    assert found.means.tolist() == [[1, 2, 3]]
    np.testing.assert_allclose(found.log_scales, np.log([[0.5, 0.25, 0.125]]), rtol=1e-6)
    np.testing.assert_allclose(found.rgb, [[0, 0.2, 1.0]], atol=1e-7)
    np.testing.assert_allclose(found.opacity_logits, [np.log(51 / 204)], rtol=1e-6)
    np.testing.assert_allclose(found.quats, [[0, 127 / 128, 0, -127 / 128]])


def test_opacities_of_0_and_1_have_finite_logits(written: Write) -> None:
    rows = [ROW.pack(0, 0, 0, 1, 1, 1, 0, 0, 0, opacity, 255, 128, 128, 128) for opacity in (0, 255)]
    found = read_splat(written("x.splat", b"".join(rows))).static.opacity_logits
    np.testing.assert_allclose(found, [-np.log(1e6), np.log(1e6)], rtol=1e-4)


def test_large_and_opaque_splats_come_first() -> None:
    splats = plain(4)
    splats.log_scales[2], splats.opacity_logits[3], splats.opacity_logits[0] = 0.0, 3.0, -3.0
    found = [row[0] * 64 for row in ROW.iter_unpack(splat_file(splats).data)]
    assert found == [2, 3, 1, 0]


def test_what_is_written_is_read_within_a_byte(written: Write) -> None:
    given = statics()
    found = read_splat(written("x.splat", splat_file(given).data)).static
    order = [int(np.abs(given.means - mean).sum(axis=1).argmin()) for mean in found.means]
    before = given.take(order)
    assert sorted(order) == list(range(50))
    np.testing.assert_array_equal(found.means, before.means)
    np.testing.assert_allclose(found.log_scales, before.log_scales, atol=1e-5)
    np.testing.assert_allclose(found.rgb, before.rgb, atol=0.5 / 255 + 1e-6)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(before.quats), atol=0.03)


def test_colours_and_opacities_are_rounded_to_bytes_and_limited() -> None:
    rgb, logits = np.float32([[-0.1, 0.5, 1.5], [1.4 / 255, 1.6 / 255, 0]]), np.float32([0.0, np.inf])
    assert rgba_bytes(rgb, logits).tolist() == [[0, 128, 255, 128], [1, 2, 0, 255]]


def test_an_opacity_that_a_byte_rounds_to_nothing_is_replaced_and_not_rounded() -> None:
    logits = np.float32([np.log(x / (1 - x)) for x in (1 / 511, 0.3, 0.2)])
    found = counted(opacity_changes(logits, np.array([0, 77, 51], np.uint8)))
    assert found == {("replaced", "opacity"): 1, ("rounded", "opacity"): 1}


def test_scales_beyond_floats_are_limited_and_every_kind_of_loss_is_counted(still: HybridScene[np.ndarray]) -> None:
    given = plain_but(log_scales={7: -100.0, 8: 90.0}, rgb={1: -0.25, 2: 1.75}).static
    found = counted(splat_file(given).changes)
    assert (found["limited", "scale"], found["limited", "colour"]) == (2, 2)
    deviations = {row[3] for row in ROW.iter_unpack(splat_file(given).data)}
    assert deviations == {np.float32(np.exp(np.float32(x))) for x in (-80, -2, 80)}
    rounded = counted(splat_file(dataclasses.replace(still.static, rgb=still.static.rgb)).changes)
    assert (rounded["rounded", "colour"], rounded["rounded", "rotation"]) == (50, 50)


@pytest.mark.parametrize(
    ("data", "problem"), [(b"1234", "has 4 bytes, no multiple of 32"), (b"", "has 0 bytes"), (None, "cannot be read")]
)
def test_a_file_that_is_none_is_named(tmp_path: Path, data: bytes | None, problem: str) -> None:
    path = tmp_path / "x.splat"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(InputError, match=rf"x\.splat: {problem}"):
        read_splat(path)


def test_the_format_holds_still_scenes_alone() -> None:
    assert SPLAT.write_moving is None


def test_a_last_row_that_nobody_sees_says_that_splats_are_drawn_antialiased(written: Write) -> None:
    """It lies at the row before it, so that boxes stay as they are, and is not read."""
    plainly, noted = (splat_file(statics(), antialiased).data for antialiased in (False, True))
    assert noted[: len(plainly)] == plainly
    (row,) = ROW.iter_unpack(noted[len(plainly) :])
    assert (row[:3], row[9]) == (ROW.unpack(plainly[-32:])[:3], 0)
    found = read_splat(written("x.splat", noted))
    assert (len(found.static), found.antialiased) == (50, True)
    assert read_splat(written("y.splat", plainly)).antialiased is None
