"""GLB files of splats, read by hand as glTF 2.0 and its extension describe them, and one of another program."""

from __future__ import annotations

import dataclasses
import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.gltf.gaussian_glb import GLB, glb_file, read_gaussian_glb
from hgs_core.interchange.gltf.glb_container import glb_bytes, read_glb
from hgs_core.scene import HybridScene, StaticSplats
from tests.conftest import REPOSITORY
from tests.hgs_core.interchange.scenes import Write, axes_of, counted, plain_but, statics

VECTORS = REPOSITORY / "tests" / "vectors" / "interchange"
KHR = "KHR_gaussian_splatting"
Edit = Callable[[dict[str, Any]], object]


def parts(data: bytes) -> tuple[dict[str, Any], bytes]:
    """The JSON document and the block of bytes, by the offsets of the description."""
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def attributes(data: bytes) -> dict[str, np.ndarray]:
    """Every attribute of the first primitive, as its accessor tells."""
    document, binary = parts(data)
    found = {}
    for name, number in document["meshes"][0]["primitives"][0]["attributes"].items():
        accessor = document["accessors"][number]
        view = document["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        kind = {5126: "<f4", 5121: np.uint8}[accessor["componentType"]]
        found[name] = np.frombuffer(binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
    return found


def edited(splats: StaticSplats[np.ndarray], edit: Edit) -> bytes:
    document, binary = parts(glb_file(splats).data)
    edit(document)
    return glb_bytes(document, binary)


def covariances(splats: StaticSplats[np.ndarray]) -> np.ndarray:
    ellipsoids = axes_of(splats.quats) * np.exp(splats.log_scales.astype(np.float64))[:, None, :]
    return ellipsoids @ np.swapaxes(ellipsoids, 1, 2)


def primitive(document: dict[str, Any]) -> dict[str, Any]:
    return document["meshes"][0]["primitives"][0]


def test_what_is_written_is_what_the_extension_describes(still: HybridScene[np.ndarray]) -> None:
    splats, data = still.static, glb_file(still.static).data
    document, _ = parts(data)
    assert document["asset"]["version"] == "2.0"
    assert document["extensionsUsed"] == [KHR]
    assert primitive(document)["mode"] == 0
    assert primitive(document)["extensions"] == {KHR: {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}}
    found = attributes(data)
    up_and_back = np.float32([1, -1, -1])
    np.testing.assert_array_equal(found["POSITION"], splats.means * up_and_back)
    np.testing.assert_allclose(found[f"{KHR}:SCALE"], np.exp(splats.log_scales), rtol=1e-6)
    np.testing.assert_allclose(found[f"{KHR}:OPACITY"][:, 0], 1 / (1 + np.exp(-splats.opacity_logits)), rtol=1e-6)
    np.testing.assert_allclose(0.5 + 0.2820947917738781 * found[f"{KHR}:SH_DEGREE_0_COEF_0"], splats.rgb, atol=1e-6)
    xyzw = found[f"{KHR}:ROTATION"]
    np.testing.assert_allclose(np.linalg.norm(xyzw, axis=1), 1, atol=1e-6)
    turn = np.diag(up_and_back)
    np.testing.assert_allclose(axes_of(xyzw[:, [3, 0, 1, 2]]), turn @ axes_of(splats.quats) @ turn, atol=1e-5)


def test_places_have_bounds_and_every_array_is_of_the_block(still: HybridScene[np.ndarray]) -> None:
    document, binary = parts(glb_file(still.static).data)
    places = still.static.means * [1, -1, -1]
    assert document["accessors"][0]["min"] == places.min(axis=0).tolist()
    assert document["accessors"][0]["max"] == places.max(axis=0).tolist()
    assert sum(view["byteLength"] for view in document["bufferViews"]) == len(binary) == 60 * 50


def test_viewers_of_points_get_linear_colours_and_opacity() -> None:
    """Half of sRGB is 0.2140 of light: 55 of 255; an opacity of 51 / 255."""
    assert attributes(glb_file(plain_but().static).data)["COLOR_0"][0].tolist() == [55, 55, 55, 51]


def test_what_is_written_is_read_back_within_floats(still: HybridScene[np.ndarray], written: Write) -> None:
    found = read_gaussian_glb(written("x.glb", glb_file(still.static).data))
    np.testing.assert_array_equal(found.static.means, still.static.means)
    for name, atol in (("log_scales", 2e-6), ("quats", 1e-6), ("rgb", 1e-6)):
        np.testing.assert_allclose(getattr(found.static, name), getattr(still.static, name), atol=atol, err_msg=name)
    np.testing.assert_allclose(found.static.opacity_logits, still.static.opacity_logits, atol=1e-4)
    assert (found.lasts, found.antialiased, [one.count for one in found.changes]) == (False, False, [0])


def test_a_file_of_another_program_is_our_scene_seen_from_its_back() -> None:
    """splat-transform 2.7.1 turned these splats, from a 3DGS file with harmonics of degree 1, about z and not about x.

    Both stand upright; between them is half a turn about the upright axis.
    """
    splats = statics(12, 7)
    found = read_gaussian_glb(VECTORS / "splat_transform.glb")
    np.testing.assert_allclose(found.static.means, splats.means * [-1, 1, -1], atol=1e-6)
    np.testing.assert_allclose(found.static.rgb, splats.rgb, atol=1e-6)
    np.testing.assert_allclose(found.static.opacity_logits, splats.opacity_logits, atol=1e-5)
    turn = np.diag([-1, 1, -1])
    np.testing.assert_allclose(covariances(found.static), turn @ covariances(splats) @ turn, rtol=1e-4, atol=1e-7)
    assert {key: count for key, count in counted(found.changes).items() if count} == {
        ("left out", "view-dependent colour"): 8
    }


@pytest.mark.parametrize(
    "linear",
    [np.eye(3), 2.5 * np.eye(3)[[1, 2, 0]], np.array([[2, 0.5, 0], [0, 3, 0], [0, -1, 0.5]]), np.diag([-1.0, 1, 1])],
    ids=["moved", "turned and scaled", "sheared", "mirrored"],
)
def test_a_node_does_to_every_ellipsoid_what_its_matrix_says(
    still: HybridScene[np.ndarray], written: Write, linear: np.ndarray
) -> None:
    """The covariance of M x is M C M^T."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, (1, 2, 3)
    data = edited(still.static, lambda d: d["nodes"][0].update(matrix=matrix.T.ravel().tolist()))
    found = read_gaussian_glb(written("x.glb", data)).static
    turn = np.diag([1.0, -1, -1])
    ours = turn @ linear @ turn
    np.testing.assert_allclose(found.means, still.static.means @ ours.T + turn @ matrix[:3, 3], atol=1e-5)
    np.testing.assert_allclose(covariances(found), ours @ covariances(still.static) @ ours.T, rtol=1e-4, atol=1e-7)


def test_several_meshes_are_joined_and_what_is_no_splat_is_told(written: Write) -> None:
    def edit(document: dict[str, Any]) -> None:
        document["meshes"].append({"primitives": [{"attributes": {"POSITION": 0}}]})
        document["nodes"] += [{"mesh": 1}, {"mesh": 0}]
        document["scenes"][0]["nodes"] = [0, 1, 2]
        document["animations"] = [{}]

    found = read_gaussian_glb(written("x.glb", edited(plain_but().static, edit)))
    assert len(found.static) == 40
    assert [str(change) for change in found.changes if change.count is None] == [
        "1 parts of meshes left out: they are no splats",
        "animations left out: splats are taken as the nodes place them",
    ]


def test_linear_colours_become_the_srgb_ones_of_the_same_light(written: Write) -> None:
    """IEC 61966-2-1: light of 0.2140 is half of sRGB; here light of 0.5 is 0.7354."""
    data = edited(plain_but().static, lambda d: primitive(d)["extensions"][KHR].update(colorSpace="lin_rec709_display"))
    found = read_gaussian_glb(written("x.glb", data))
    np.testing.assert_allclose(found.static.rgb, 0.735357, atol=1e-6)
    assert counted(found.changes)["replaced", "colour"] == 20


def test_scales_beyond_floats_and_negative_colours_are_counted() -> None:
    given = plain_but(log_scales={7: -100.0, 8: 90.0}, rgb={1: -0.25, 2: 1.75}).static
    assert counted(glb_file(given).changes) == {("limited", "scale"): 2, ("limited", "colour"): 1}


def test_a_splat_that_is_not_finite_is_left_to_the_import_to_tell(written: Write) -> None:
    given = dataclasses.replace(plain_but().static, log_scales=np.full((20, 3), np.nan, np.float32))
    data = edited(given, lambda d: d["nodes"][0].update(scale=[2, 2, 2]))
    found = read_gaussian_glb(written("x.glb", data)).static
    assert np.isnan(found.log_scales).all()
    assert np.isfinite(found.means).all()


def test_no_splats_at_all_are_refused_as_gltf_has_no_empty_arrays() -> None:
    with pytest.raises(InputError, match="splats: are none, and glTF holds no empty array; choose another --time"):
        glb_file(plain_but().static.take(slice(0, 0)))


def without(name: str) -> Edit:
    return lambda document: primitive(document)["attributes"].pop(name)


def of_extension(**changed: object) -> Edit:
    return lambda document: primitive(document)["extensions"][KHR].update(changed)


@pytest.mark.parametrize(
    ("edit", "problem"),
    [
        (lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"]), "needs the extension KHR_draco_mesh"),
        (
            of_extension(extensions={f"{KHR}_compression_spz_2": {}}),
            f"stores splats by {KHR}_compression_spz_2; export",
        ),
        (of_extension(kernel="box"), "has splats of kernel 'box' in colour space 'srgb_rec709_display'"),
        (of_extension(colorSpace="aces"), "has splats of kernel 'ellipse' in colour space 'aces'"),
        (without(f"{KHR}:OPACITY"), f"has splats without {KHR}:OPACITY: it follows a draft"),
        (lambda d: primitive(d).pop("extensions"), f"holds no splats: no mesh has {KHR}"),
        (lambda d: d["accessors"][1].update(count=19), "has splats whose attributes differ in number or kind"),
        (lambda d: d.update(extensionsRequired=3), "holds JSON that is no glTF"),
        (lambda d: primitive(d).update(attributes=3), "holds JSON that is no glTF"),
    ],
)
def test_what_is_not_read_is_refused_by_name(written: Write, edit: Edit, problem: str) -> None:
    path = written("x.glb", edited(plain_but().static, edit))
    with pytest.raises(InputError) as caught:
        read_gaussian_glb(path)
    assert str(caught.value).startswith(f"{path}: {problem}")


def test_logarithms_of_a_draft_are_no_deviations(written: Write) -> None:
    data = glb_file(plain_but().static).data
    deviation = struct.pack("<f", np.float32(np.exp(np.float32(-2))))
    path = written("x.glb", data.replace(deviation, struct.pack("<f", -2.0)))
    with pytest.raises(InputError, match=r"has negative KHR_gaussian_splatting:SCALE: it follows a draft"):
        read_gaussian_glb(path)


@pytest.mark.parametrize("antialiased", [False, True])
def test_a_note_in_the_asset_says_how_still_scenes_are_drawn(written: Write, antialiased: bool) -> None:
    assert GLB.write_moving is None
    found = read_gaussian_glb(written("x.glb", glb_file(statics(), antialiased).data))
    assert found.antialiased is antialiased


@pytest.mark.parametrize("extras", [None, [], {"hgs_antialiased": "yes"}, 3])
def test_other_notes_say_nothing(written: Write, extras: object) -> None:
    document, binary = read_glb(written("x.glb", glb_file(statics(), True).data))
    document["asset"]["extras"] = extras
    assert read_gaussian_glb(written("y.glb", glb_bytes(document, binary))).antialiased is None
