"""Splats of other programs: other names, other meanings of numbers, places far away."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.interchange import import_scene
from hgs_core.interchange.changes import nonzero
from hgs_core.interchange.ply_table import write_ply
from hgs_core.interchange.smoothing_filter import fused
from hgs_core.render.rasterize import rasterize
from hgs_core.scene import StaticSplats
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.opacities import opacities_of
from tests.hgs_core.interchange.scenes import Write, statics

COUNT = 300
UNTOLD = "drawing without antialiasing"


def columns(count: int = COUNT) -> dict[str, np.ndarray]:
    s = statics(count)
    names = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"]
    table = np.concatenate([s.means, s.log_scales, s.quats, s.opacity_logits[:, None]], axis=1)
    dc = {f"f_dc_{i}": (s.rgb[:, i] - 0.5) / 0.28209479 for i in range(3)}
    return dict(zip(names, table.T.astype(np.float64), strict=True)) | dc


def but(table: dict[str, np.ndarray], rename: dict[str, str], **more: np.ndarray) -> dict[str, np.ndarray]:
    return {rename.get(name, name): array for name, array in table.items() if rename.get(name, name)} | more


def told(path: Path, **options: object) -> tuple[StaticSplats[np.ndarray], list[str]]:
    found = import_scene(path, **options)  # type: ignore[arg-type]
    return found.scene.static, [change.what for change in found.changes if change.what != UNTOLD]


def test_other_names_are_known(written: Write) -> None:
    plain, _ = told(written("x.ply", write_ply(columns())))
    names = {"opacity": "alpha", "rot_0": "qw", "rot_1": "qx", "rot_2": "qy", "rot_3": "qz"}
    names |= {f"scale_{i}": f"scale_{axis}" for i, axis in enumerate("xyz")}
    found, changes = told(written("y.ply", write_ply(but(columns(), names))))
    for name, array in plain.items():
        np.testing.assert_array_equal(getattr(found, name), array)
    assert changes == []


@pytest.mark.parametrize(("names", "most"), [(("red", "green", "blue"), 255), (("r", "g", "b"), 1)])
def test_plain_colours_take_the_place_of_harmonics(written: Write, names: tuple[str, ...], most: float) -> None:
    rgb = statics(COUNT).rgb
    table = but(columns(), {f"f_dc_{i}": "" for i in range(3)}, **dict(zip(names, most * rgb.T, strict=True)))
    found, _ = told(written("x.ply", write_ply(table)))
    np.testing.assert_allclose(found.rgb, rgb, atol=1e-6)


def activated(table: dict[str, np.ndarray], *, scales: bool = True, opacity: bool = True) -> dict[str, np.ndarray]:
    found = dict(table)
    for i in range(3 if scales else 0):
        found[f"scale_{i}"] = np.exp(table[f"scale_{i}"])
    if opacity:
        found["opacity"] = opacities_of(table["opacity"])
    return found


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, ["scale", "opacity"]),
        ({"scales": False}, ["opacity"]),
    ],
)
def test_numbers_as_they_are_drawn_become_logarithms_and_logits(
    written: Write, given: dict[str, bool], expected: list[str]
) -> None:
    plain, _ = told(written("x.ply", write_ply(columns())))
    found, changes = told(written("y.ply", write_ply(activated(columns(), **given))))
    assert changes == expected
    np.testing.assert_allclose(found.log_scales, plain.log_scales, atol=1e-5)
    np.testing.assert_allclose(found.opacity_logits, plain.opacity_logits, atol=1e-3)


def test_where_ranges_fit_both_the_answer_is_asked_for_and_taken(written: Write) -> None:
    same = columns() | {"opacity": np.full(COUNT, 0.9)}
    path = written("x.ply", write_ply(same))
    with pytest.raises(InputError, match=r"import it with --activated if so, with --no-activated if they are"):
        import_scene(path)
    logits, changes = told(path, activated=False)
    assert (float(logits.opacity_logits[0]), changes) == (np.float32(0.9), [])
    drawn = written("y.ply", write_ply(activated(columns(), opacity=False)))
    with pytest.raises(InputError, match="all scales are positive"):
        import_scene(drawn)
    both = written("z.ply", write_ply(activated(same, opacity=False)))
    found, changes = told(both, activated=True)
    assert changes == ["scale", "opacity"]
    np.testing.assert_allclose(opacities_of(found.opacity_logits), 0.9, rtol=1e-5)


def test_millimetres_have_positive_logarithms_of_scales(written: Write) -> None:
    table = columns() | {f"scale_{i}": columns()[f"scale_{i}"] + np.log(1000) for i in range(3)}
    table |= {axis: columns()[axis] * 1000 for axis in "xyz"}
    assert (table["scale_0"] > 0).all()
    assert told(written("x.ply", write_ply(table)))[1] == []


def test_a_surfel_is_a_flat_splat(written: Write) -> None:
    found, changes = told(written("x.ply", write_ply(but(columns(), {"scale_2": ""}))))
    assert changes == ["thickness"]
    np.testing.assert_allclose(found.log_scales[:, 2], np.log(1e-6), rtol=1e-6)
    np.testing.assert_allclose(found.log_scales[:, :2], statics(COUNT).log_scales[:, :2])


def test_a_smoothing_filter_is_fused_as_its_trainer_does(written: Write) -> None:
    """Mip-Splatting: variances grow by the filter's square, opacity by the root of the ratio of determinants."""
    widths = np.random.default_rng(0).uniform(0.001, 0.1, COUNT)
    widths[:5] = 0.0
    found, changes = told(written("x.ply", write_ply(columns() | {"filter_3D": widths})))
    assert changes == ["scale and opacity"]
    given = statics(COUNT)
    before = np.exp(2.0 * given.log_scales)
    after = before + widths[:, None].astype(np.float32) ** 2
    np.testing.assert_allclose(np.exp(2.0 * found.log_scales), after, rtol=1e-4)
    share = np.sqrt(before.prod(axis=1) / after.prod(axis=1))
    np.testing.assert_allclose(
        opacities_of(found.opacity_logits), np.maximum(opacities_of(given.opacity_logits) * share, 1e-6), rtol=1e-3
    )
    assert nonzero([fused(given.log_scales, given.opacity_logits, np.zeros(COUNT))[2]]) == ()


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6, 1e7])
def test_far_away_places_look_as_they_do_near_the_origin(written: Write, offset: float) -> None:
    """Map coordinates in 64 bits: from the same place beside them the picture is the same."""
    names = list(columns())
    rows = np.stack([*columns().values()], axis=1)
    rows[:, :2] += [offset, 12 * offset]
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 300\n"
    header += "".join(f"property double {name}\n" for name in names) + "end_header\n"
    found = import_scene(written("x.ply", header.encode() + rows.tobytes()))
    places = [change for change in found.changes if change.what == "places"]
    assert len(places) == (offset >= 1e3)
    middle = np.zeros(3)
    if places:
        middle = np.array([float(part) for part in str(places[0]).partition("(")[2].partition(")")[0].split(",")])
    near = [offset, 12 * offset, 0] - middle
    pictures = []
    for splats, eye in ((found.scene.static, near), (statics(COUNT), np.zeros(3))):
        camera = Camera("", 64, 64, 60, 60, 32, 32, looking_at(eye + np.array([0, 0, -8.0]), eye))
        drawn = rasterize(splats.map(torch.from_numpy), None, camera, gradients="none")
        pictures.append(drawn.rgb.numpy())
    assert -10 * np.log10(((pictures[0] - pictures[1]) ** 2).mean() + 1e-12) > 50


def test_a_capture_keeps_places_where_they_are(written: Write) -> None:
    table = columns() | {"x": columns()["x"] + 1e6}
    found = import_scene(written("x.ply", write_ply(table)), centred=False)
    assert np.median(found.scene.static.means[:, 0]) == pytest.approx(1e6, rel=1e-3)
