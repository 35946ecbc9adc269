"""Point clouds of 3DGS: its properties, its colours, and unsupported ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.interchange.ply.gaussian_ply import gaussian_ply, gaussian_splats
from hgs_core.interchange.ply.ply_table import read_ply
from hgs_core.interchange.splat_properties import SH_0
from tests.hgs_core.interchange.scenes import Write, counted, plain, plain_but, statics

FIELDS = (
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "f_dc_0",
    "f_dc_1",
    "f_dc_2",
    "opacity",
    "scale_0",
    "scale_1",
    "scale_2",
    "rot_0",
    "rot_1",
    "rot_2",
    "rot_3",
)


def table(**more: np.ndarray) -> dict[str, np.ndarray]:
    """Three splats of which every property tells its name."""
    return {name: np.float32([i, i + 100, i + 200]) for i, name in enumerate(FIELDS)} | more


def test_every_property_goes_where_it_belongs() -> None:
    found = gaussian_splats(Path("x.ply"), table())
    splats = found.static
    assert splats.means.tolist()[1] == [100, 101, 102]
    assert splats.log_scales.tolist()[0] == [10, 11, 12]
    assert splats.quats.tolist()[2] == [213, 214, 215, 216]
    assert splats.opacity_logits.tolist() == [9, 109, 209]
    np.testing.assert_allclose(splats.rgb[1], 0.5 + 0.28209479 * np.array([106, 107, 108]), rtol=1e-6)
    assert nonzero(found.changes) == ()


def test_the_constant_harmonic_is_half_the_root_of_one_over_pi() -> None:
    assert pytest.approx(0.5 / np.sqrt(np.pi), rel=1e-15) == SH_0


def test_a_file_has_the_properties_of_its_trainer_in_order_and_gives_the_same_floats(written: Write) -> None:
    given = statics()
    path = written("x.ply", gaussian_ply(given).data)
    found = read_ply(path).vertices
    assert tuple(found) == FIELDS
    splats = gaussian_splats(path, found).static
    for name in ("means", "log_scales", "quats", "opacity_logits"):
        np.testing.assert_array_equal(getattr(splats, name), getattr(given, name))
    np.testing.assert_allclose(splats.rgb, given.rgb, atol=1e-6)


@pytest.mark.parametrize(("degree", "coefficients"), [(1, 9), (2, 24), (3, 45)])
def test_higher_harmonics_are_left_out_and_only_splats_that_have_some_are_counted(
    degree: int, coefficients: int
) -> None:
    rest = {f"f_rest_{i}": np.float32([0, i == 4, 0]) for i in range(coefficients)}
    reason = f"spherical harmonics of degree 1 to {degree}: colours are the same from every direction"
    changes = gaussian_splats(Path("x.ply"), table(**rest)).changes
    assert list(nonzero(changes)) == [Change(Action.LEFT_OUT, "view-dependent colour", 1, 3, reason)]


def test_further_properties_are_told_and_a_missing_one_is_named() -> None:
    changes = gaussian_splats(Path("x.ply"), table(label=np.zeros(3, np.float32))).changes
    assert counted(nonzero(changes)) == {("left out", "properties label"): None}
    missing = table()
    del missing["rot_2"]
    with pytest.raises(InputError, match="has no vertex property rot_2"):
        gaussian_splats(Path("x.ply"), missing)


def test_logits_that_viewers_cannot_take_are_limited_and_dark_colours_told(written: Write) -> None:
    given = plain_but(opacity_logits={0: np.inf, 1: -31.0, 2: 30.0}, rgb={3: -0.25, 4: 1.75}).static
    data, changes = gaussian_ply(given).data, gaussian_ply(given).changes
    assert counted(changes) == {("limited", "opacity"): 2, ("limited", "colour"): 1}
    found = gaussian_splats(Path("x.ply"), read_ply(written("x.ply", data)).vertices).static
    assert found.opacity_logits[:3].tolist() == [30, -30, 30]


def test_what_the_format_holds_is_not_counted() -> None:
    assert set(counted(gaussian_ply(plain()).changes).values()) == {0}
