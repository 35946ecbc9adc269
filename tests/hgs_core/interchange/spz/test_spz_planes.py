from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.spz.spz_planes import pack, unpack, widths
from hgs_core.scene import HybridScene
from tests.hgs_core.interchange.scenes import counted, plain_but


@pytest.mark.parametrize(
    ("version", "degree", "each"),
    [
        (2, 0, (9, 1, 3, 3, 3, 0)),
        (3, 1, (9, 1, 3, 3, 4, 9)),
        (4, 4, (9, 1, 3, 3, 4, 72)),
    ],
)
def test_planes_have_the_widths_of_version_and_degree(version: int, degree: int, each: tuple[int, ...]) -> None:
    assert widths(version, degree) == each


def test_splats_are_packed_into_planes_of_those_widths(still: HybridScene[np.ndarray]) -> None:
    for version in (2, 3):
        assert [plane.shape for plane in pack(still.static, version).planes] == [(50, w) for w in widths(version, 0)]


def test_what_planes_change_is_what_unpacking_them_shows(still: HybridScene[np.ndarray]) -> None:
    packed = pack(still.static, 3)
    found, left_out = unpack(packed.planes, packed.bits)
    assert left_out == []
    moved = (np.abs(found.means - still.static.means) > 1e-6).any(axis=1).sum()
    assert counted(packed.changes)["rounded", "position"] == moved


def test_fewer_fractional_bits_are_taken_far_from_the_origin() -> None:
    assert [pack(plain_but(means={3: x}).static, 3).bits for x in (100.0, 2047.9, 2048.1, 9e4)] == [12, 12, 11, 6]


def test_a_place_beyond_24_bits_is_refused() -> None:
    with pytest.raises(InputError, match=r"splats: reach 9e\+06 from the origin; SPZ holds less than 8,388,607"):
        pack(plain_but(means={3: -9e6}).static, 3)
