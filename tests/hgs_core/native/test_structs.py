"""The structs against src/hgs_native.h, read by a few lines of Python."""

from __future__ import annotations

import ctypes
import dataclasses
import re

import numpy as np
import pytest

from hgs_core.native import structs
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.camera import Camera
from tests.conftest import REPOSITORY

HEADER = (REPOSITORY / "hgs_core" / "native" / "src" / "hgs_native.h").read_text()
C_TYPES = {"int32_t": ctypes.c_int32, "int64_t": ctypes.c_int64, "float": ctypes.c_float, "double": ctypes.c_double}
CAMERA = Camera("", 64, 48, 50.0, 51.0, 32.0, 24.0, np.diag([1.0, -1.0, -1.0, 1.0]) + np.eye(4, k=3) * 7, near=0.25)
STRUCTS = {
    "camera": type(structs.c_camera(CAMERA)),
    "view": structs.CView,
    "picture": structs.CPicture,
    "static_splats": structs.CStaticSplats,
    "dynamic_splats": structs.CDynamicSplats,
    "static_gradients": structs.CStaticGradients,
    "dynamic_gradients": structs.CDynamicGradients,
    "screen_statistics": structs.CScreenStatistics,
    "measurements": structs.CMeasurements,
}


def declared(name: str) -> list[tuple[str, str]]:
    """The fields of a struct of the header, with their types: a type, "type[n]" or "pointer"."""
    found = re.search(rf"typedef struct hgs_{name} {{(.*?)}} hgs_{name};", HEADER, re.S)
    assert found is not None
    fields = []
    for declaration in re.sub(r"/\*.*?\*/", "", found[1], flags=re.S).split(";")[:-1]:
        kind, names = declaration.replace("const ", "").split(maxsplit=1)
        for field in names.split(","):
            plain, count = re.fullmatch(r"\**(\w+)(\[\d+\])?", field.strip()).groups()  # type: ignore[union-attr]
            fields.append((plain, "pointer" if "*" in field else kind + (count or "")))
    return fields


def as_c(kind: object) -> str:
    names = {ctypes.c_void_p: "pointer", STRUCTS["camera"]: "hgs_camera"}
    names |= {found: name for name, found in C_TYPES.items()}
    if isinstance(kind, type) and issubclass(kind, ctypes.Array):
        return f"{names[kind._type_]}[{kind._length_}]"
    return names[kind]


@pytest.mark.parametrize("name", STRUCTS)
def test_every_struct_has_the_fields_of_the_header(name: str) -> None:
    assert [(field, as_c(kind)) for field, kind, *_ in STRUCTS[name]._fields_] == declared(name)


def test_the_largest_side_is_the_headers() -> None:
    assert f"#define HGS_MAX_SIDE {structs.MAX_SIDE}\n" in HEADER


def test_a_camera_keeps_its_numbers_and_its_pose_row_by_row() -> None:
    found = structs.c_camera(CAMERA)
    assert [found.width, found.height, found.fx, found.fy, found.cx, found.cy] == [64, 48, 50, 51, 32, 24]
    assert list(found.rotation) == [1, 0, 0, 0, -1, 0, 0, 0, -1]
    assert (list(found.translation), found.near_plane) == ([7, 0, 0], 0.25)


@pytest.mark.parametrize("side", ["width", "height"])
def test_a_picture_too_large_for_the_kernels_is_refused(side: str) -> None:
    with pytest.raises(ValueError, match="65535 pixels along a side, not"):
        structs.c_camera(dataclasses.replace(CAMERA, **{side: 65536}))


def statics(count: int = 2) -> StaticSplats[np.ndarray]:
    shapes = ((3,), (3,), (4,), (), (3,))
    return StaticSplats(*(np.full((count, *shape), 1 + i, np.float32) for i, shape in enumerate(shapes)))


def test_a_set_is_pointed_at_field_by_field() -> None:
    splats = statics()
    found = structs.statics_struct(splats)
    firsts = [ctypes.c_float.from_address(getattr(found, name)).value for name, _ in splats.items()]
    assert (found.count, firsts) == (2, [1, 2, 3, 4, 5])


def test_no_set_is_one_of_no_splats() -> None:
    assert (structs.statics_struct(None).count, structs.statics_struct(None).means) == (0, None)
    assert (structs.dynamics_struct(None).count, structs.dynamics_struct(None).coefficients) == (0, 4)


@pytest.mark.parametrize("coefficients", [4, 6])
def test_the_kernels_are_told_how_many_coefficients_the_motion_has(coefficients: int) -> None:
    assert structs.dynamics_struct(DynamicSplats.empty(coefficients)).coefficients == coefficients


def test_an_array_of_another_shape_is_named() -> None:
    with pytest.raises(ValueError, match=r"quats must be a contiguous float32 array of shape \(2, 4\)"):
        structs.statics_struct(dataclasses.replace(statics(), quats=np.zeros((2, 3), np.float32)))
    with pytest.raises(ValueError, match=r"motion must be a contiguous float32 array of shape \(0, 4, 3\)"):
        structs.dynamics_struct(DynamicSplats.empty(5))


def test_gradients_go_where_they_are_wanted_and_an_absent_set_is_left_out() -> None:
    place = np.zeros((2, 3), np.float32)
    struct = structs.CStaticGradients()
    assert structs.gradients_struct(struct, {"rgb": place}, 2, structs.STATIC_SHAPES) is not None
    assert (struct.rgb, struct.means) == (place.ctypes.data, None)
    assert structs.gradients_struct(struct, None, 2, structs.STATIC_SHAPES) is None
    with pytest.raises(ValueError, match="gradient of rgb must be"):
        structs.gradients_struct(struct, {"rgb": place}, 3, structs.STATIC_SHAPES)
