"""SOG files of ours: read by a decoder of its own here, by the reader, and by PlayCanvas' splat-transform.

`hgs.sog` is the file of the 50 random splats, `hgs_by_splat_transform.ply` what splat-transform 3.7.0 made of it. That
program is no devDependency: with the packages it needs it weighs 215 MB. HGS_SPLAT_TRANSFORM names an installed one.
"""

from __future__ import annotations

import dataclasses
import io
import json
import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.interchange import import_scene
from hgs_core.interchange.ply.ply_table import read_ply
from hgs_core.interchange.sog_writer import sog_file
from hgs_core.interchange.still_moment import scene_at
from hgs_core.metrics.psnr import psnr
from hgs_core.scene.opacities import opacities_of
from tests.hgs_core.interchange.gltf.test_gaussian_glb import VECTORS
from tests.hgs_core.interchange.scenes import (
    axes_of,
    counted,
    export,
    figure,
    figure_picture,
    plain,
    plain_but,
    statics,
)

HARMONIC = 0.28209479177387814


def decoded(data: bytes) -> dict[str, np.ndarray]:
    """The splats of a file by the format's description alone."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        meta = json.loads(archive.read("meta.json"))
        pixels = {
            name: np.asarray(Image.open(io.BytesIO(archive.read(f"{name}.webp")))).reshape(-1, 4)[: meta["count"]]
            for name in ("means_l", "means_u", "scales", "quats", "sh0")
        }
    share = (pixels["means_u"][:, :3] * 256.0 + pixels["means_l"][:, :3]) / 65535
    logs = np.array(meta["means"]["mins"]) * (1 - share) + np.array(meta["means"]["maxs"]) * share
    quats = []
    for *three, tag in pixels["quats"].tolist():
        others = [(value / 255 - 0.5) * 2**0.5 for value in three]
        others.insert(tag - 252, (1 - sum(value * value for value in others)) ** 0.5)
        quats.append(others)
    return {
        "means": np.sign(logs) * (np.exp(np.abs(logs)) - 1),
        "log_scales": np.array(meta["scales"]["codebook"])[pixels["scales"][:, :3]],
        "quats": np.array(quats),
        "opacity": pixels["sh0"][:, 3] / 255,
        "dc": np.array(meta["sh0"]["codebook"])[pixels["sh0"][:, :3]],
    }


def by_place(places: np.ndarray) -> np.ndarray:
    return np.argsort(places[:, 0])


def test_a_decoder_of_its_own_finds_the_splats() -> None:
    given = statics()
    found = decoded(sog_file(given).data)
    ours, theirs = by_place(given.means), by_place(found["means"])
    np.testing.assert_allclose(found["means"][theirs], given.means[ours], atol=3e-4)
    np.testing.assert_array_equal(found["log_scales"][theirs], given.log_scales[ours])  # 150 numbers fit a table
    np.testing.assert_allclose(axes_of(found["quats"][theirs]), axes_of(given.quats[ours]), atol=0.015)
    np.testing.assert_allclose(found["opacity"][theirs], opacities_of(given.opacity_logits[ours]), atol=0.00197)
    np.testing.assert_allclose(0.5 + HARMONIC * found["dc"][theirs], given.rgb[ours], atol=1e-6)


def test_the_reader_finds_the_same_and_how_they_are_drawn(tmp_path: Path) -> None:
    for antialiased in (True, False):
        scene = dataclasses.replace(plain_but(), antialiased=antialiased)
        export(scene, tmp_path / "x.sog")
        found = import_scene(tmp_path / "x.sog").scene
        assert found.antialiased is antialiased
        order = by_place(found.static.means)
        np.testing.assert_allclose(found.static.means[order], plain().means, atol=1e-5)
        np.testing.assert_array_equal(found.static.log_scales, plain().log_scales)


def test_a_moment_looks_as_the_renderer_draws_the_exact_scene(tmp_path: Path) -> None:
    scene = figure()
    export(scene, tmp_path / "x.sog", time=0.5)
    found = import_scene(tmp_path / "x.sog").scene
    assert len(found.static) == len(scene_at(scene, 0.5))
    assert psnr(figure_picture(found, 0.0), figure_picture(scene, 0.5)) > 45


def test_of_each_kind_the_rounded_splats_are_counted() -> None:
    rng = np.random.default_rng(1)
    given = statics(400)
    given.opacity_logits[:200] = np.log(51 / 204)
    given.opacity_logits[-1] = -9.0
    given.quats[:100] = [1, 0, 0, 0]
    found = counted(sog_file(dataclasses.replace(given, rgb=rng.random((400, 3)).astype(np.float32))).changes)
    assert found[("replaced", "opacity")] == 1
    assert found[("rounded", "opacity")] == 199
    assert found[("rounded", "rotation")] == 400  # 0 lies between two bytes
    assert {name for _, name in found} == {"position", "scale", "colour", "opacity", "rotation"}


def test_colours_of_splats_without_opacity_are_kept() -> None:
    given = dataclasses.replace(statics(20), opacity_logits=np.full(20, -30, np.float32))
    found = decoded(sog_file(given).data)
    colours = (given.rgb[by_place(given.means)] - 0.5) / HARMONIC
    np.testing.assert_allclose(found["dc"][by_place(found["means"])], colours, atol=1e-6)
    assert not found["opacity"].any()


def test_neighbours_lie_beside_each_other() -> None:
    def step(places: np.ndarray) -> float:
        return float(np.linalg.norm(np.diff(places, axis=0), axis=1).mean())

    given = statics(2000)
    assert step(decoded(sog_file(given).data)["means"]) < step(given.means) / 4


def test_no_splats_are_no_file() -> None:
    with pytest.raises(InputError, match="splats: are none, and SOG holds no empty picture; choose another time"):
        sog_file(plain(0))


def test_splat_transform_has_read_the_file_that_is_written() -> None:
    given, table = (
        decoded((VECTORS / "hgs.sog").read_bytes()),
        read_ply(VECTORS / "hgs_by_splat_transform.ply").vertices,
    )
    now = decoded(sog_file(statics(), True).data)
    for name, values in given.items():
        np.testing.assert_allclose(now[name], values, rtol=1e-12, err_msg=name)
    assert len(table["x"]) == 50
    _same(given, table)


def test_splat_transform_reads_it(tmp_path: Path) -> None:
    program = os.environ.get("HGS_SPLAT_TRANSFORM") or shutil.which("splat-transform")
    if program is None:
        pytest.skip("splat-transform is not installed (npm: @playcanvas/splat-transform, 215 MB)")
    given = sog_file(statics(3000)).data
    (tmp_path / "x.sog").write_bytes(given)
    subprocess.run([program, "-q", "-w", "x.sog", "x.ply"], cwd=tmp_path, check=True)
    _same(decoded(given), read_ply(tmp_path / "x.ply").vertices)


def _same(given: dict[str, np.ndarray], table: dict[str, np.ndarray]) -> None:
    def columns(*names: str) -> np.ndarray:
        return np.stack([table[name] for name in names], axis=1)

    np.testing.assert_allclose(columns("x", "y", "z"), given["means"], rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(columns("scale_0", "scale_1", "scale_2"), given["log_scales"], rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(columns("f_dc_0", "f_dc_1", "f_dc_2"), given["dc"], rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(opacities_of(table["opacity"]), given["opacity"], atol=2e-3)
    turns = columns("rot_0", "rot_1", "rot_2", "rot_3")
    np.testing.assert_allclose(axes_of(turns), axes_of(given["quats"]), atol=1e-5)
