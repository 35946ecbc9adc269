"""What files of others hold, and what is refused."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange import Action, Change, export_scene, import_scene
from hgs_core.interchange.ply_table import write_ply
from hgs_core.interchange.spz_file import read_spz, spz_file
from hgs_core.scene import HybridScene
from hgs_core.scene.camera import Camera

CAMERA = Camera("cam00", 640, 480, 500.0, 510.0, 320.0, 240.0, np.eye(4))
FIELDS = ["x", "y", "z", *(f"f_dc_{i}" for i in range(3)), "opacity", *(f"scale_{i}" for i in range(3))]
FIELDS += [f"rot_{i}" for i in range(4)]
Write = Callable[[str, bytes], Path]


def table(count: int = 3, **more: np.ndarray) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(0)
    return {name: rng.normal(size=count).astype(np.float32) for name in FIELDS} | more


def test_higher_harmonics_are_left_out_and_counted(written: Write) -> None:
    rest = {f"f_rest_{i}": np.ones(3, np.float32) for i in range(45)}
    given = table(**rest)
    found = import_scene(written("x.ply", write_ply(given)), 1.0)
    reason = "spherical harmonics of degree 1 to 3: colours are the same from every direction"
    assert found.changes[0] == Change(Action.LEFT_OUT, "view-dependent colour", 3, 3, reason)
    expected = np.maximum(0.5 + 0.28209479 * np.stack([given[f"f_dc_{i}"] for i in range(3)], axis=1), 0)
    np.testing.assert_allclose(found.scene.static.rgb, expected, rtol=1e-6)


def test_splats_that_are_no_numbers_are_left_out_and_counted(written: Write) -> None:
    given = table(4)
    given["x"][1] = np.nan
    given["opacity"][2] = np.inf  # an opacity of 1
    found = import_scene(written("x.ply", write_ply(given)), 1.0)
    assert len(found.scene.static) == 3
    assert Change(Action.LEFT_OUT, "splats", 1, 4, "position is no finite number") in found.changes
    assert Change(Action.LIMITED, "opacity", 1, 3, "to 0.000001 to 0.999999") in found.changes


def test_properties_of_any_type_and_order_are_read_by_name(written: Write) -> None:
    header = "ply\nformat binary_little_endian 1.0\ncomment made by hand\nelement vertex 1\nproperty uchar flag\n"
    names = [*FIELDS[::-1]]
    header += "".join(f"property double {name}\n" for name in names) + "element face 0\nend_header\n"
    values = {name: float(i) for i, name in enumerate(FIELDS)}
    row = bytes([7]) + np.array([values[name] for name in names], "<f8").tobytes()
    found = import_scene(written("x.ply", header.encode() + row), 1.0).scene.static
    assert found.means.tolist() == [[0, 1, 2]]
    assert found.quats.tolist() == [[10, 11, 12, 13]]


def ply(header: str, rows: bytes = b"") -> bytes:
    return b"ply\n" + header.encode() + b"end_header\n" + rows


BINARY = "format binary_little_endian 1.0\n"


@pytest.mark.parametrize(
    ("name", "data", "problem"),
    [
        ("x.obj", b"", "has the suffix '.obj'; give one of .ply, .splat, .spz"),
        ("x.ply", b"hello", "is not a PLY file"),
        ("x.ply", ply("format ascii 1.0\nelement vertex 1\nproperty float x\n"), "is in the format ascii"),
        ("x.ply", ply(BINARY + "element vertex 9\nproperty float x\n", b"123"), "has 3 bytes of vertices, 9 need 36"),
        ("x.ply", ply(BINARY + "element face 9\n"), "begins with the element face 9"),
        ("x.ply", ply(BINARY + "element vertex 1\nproperty list uchar int i\n"), "has vertices with lists"),
        ("x.ply", ply(BINARY + "element vertex 1\nproperty float x\n", b"1234"), "has no vertex property y"),
        ("x.ply", ply(BINARY), "has no vertices"),
        ("x.ply", write_ply(table(0)), "holds no splats"),
        ("x.splat", b"1234", "has 4 bytes, no multiple of 32"),
        ("x.splat", b"", "has 0 bytes"),
        ("x.spz", b"1234", "is not a gzipped SPZ file"),
        ("x.spz", gzip.compress(b"1234"), "holds 4 bytes without an SPZ header"),
        ("x.spz", gzip.compress(b"NGSP\x04\0\0\0" + bytes(8)), "is of version 4"),
        ("x.spz", gzip.compress(b"NGSP\x02\0\0\0\x05\0\0\0\0\x0c\0\0"), "has 16 bytes, 5 splats need"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_in_one_line(written: Write, name: str, data: bytes, problem: str) -> None:
    path = written(name, data)
    with pytest.raises(InputError) as caught:
        import_scene(path, 1.0)
    assert str(caught.value).startswith(f"{path}: {problem}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["x.ply", "x.splat", "x.spz"])
def test_a_missing_file_is_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=name):
        import_scene(tmp_path / name, 1.0)


@pytest.mark.parametrize(
    ("name", "more", "problem"),
    [
        ("x.obj", {}, "has the suffix '.obj'"),
        ("x.splat", {}, "holds one moment, and this scene moves; add --time 2 to 4"),
        ("x.splat", {"time": 5.0}, "--time: 5.0 s is outside the scene; give 2 to 4"),
        ("x.splatv", {"time": 3.0}, "--time: is not for .splatv"),
        ("x.ply", {"segment": 1}, "--segment: 1 is not one of the scene's; give one of 0 to 0"),
    ],
)
def test_an_export_that_cannot_be_is_refused_and_nothing_is_written(
    scene: HybridScene[np.ndarray], tmp_path: Path, name: str, more: dict[str, float], problem: str
) -> None:
    with pytest.raises(InputError, match=problem.replace(".", r"\.")):
        export_scene(scene, tmp_path / name, cameras=[CAMERA], **more)  # type: ignore[arg-type]
    assert not any(tmp_path.iterdir())


def test_spz_of_version_2_has_coarser_rotations_in_a_byte_less(still: HybridScene[np.ndarray], written: Write) -> None:
    raw = [len(gzip.decompress(spz_file(still.static, version=version).data)) for version in (2, 3)]
    assert raw == [16 + 50 * 19, 16 + 50 * 20]
    found = read_spz(written("x.spz", spz_file(still.static, version=2).data))[0]
    turn = np.abs((found.quats * still.static.quats).sum(axis=1))
    assert turn.min() > 0.99  # w is made good from the others, badly where it is small


def test_spz_takes_fewer_fractional_bits_far_from_the_origin(still: HybridScene[np.ndarray], written: Write) -> None:
    far = type(still.static)(still.static.means * 1e4, *(a for _, a in list(still.static.items())[1:]))
    found = read_spz(written("x.spz", spz_file(far).data))[0]
    np.testing.assert_allclose(found.means, far.means, atol=0.5 / 64)
