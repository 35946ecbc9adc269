"""PLY files, written and read by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action
from hgs_core.interchange.ply.ply_table import columns, left_over, read_ply, rounded, write_ply
from tests.hgs_core.interchange.scenes import Write

BINARY = "format binary_little_endian 1.0\n"


def ply(header: str, rows: bytes = b"") -> bytes:
    return b"ply\n" + header.encode() + b"end_header\n" + rows


def test_a_table_is_written_row_by_row_as_floats() -> None:
    data = write_ply({"x": np.float32([1, 2]), "y": np.float32([3, 4])})
    expected = BINARY + "element vertex 2\nproperty float x\nproperty float y\n"
    assert data == ply(expected, np.array([1, 3, 2, 4], "<f4").tobytes())


def test_properties_of_any_type_and_order_are_read_by_name(written: Write) -> None:
    header = BINARY + "comment made by hand\nelement vertex 2\nproperty uchar flag\nproperty double z\n"
    header += "property short y\nproperty float32 x\nelement face 0\n"
    rows = np.array([(7, 0.25, -3, 1.5), (8, 0.5, -4, 2.5)], "u1, <f8, <i2, <f4").tobytes()
    table = read_ply(written("x.ply", ply(header, rows))).vertices
    found = {name: array.tolist() for name, array in table.items()}
    assert found == {"flag": [7, 8], "z": [0.25, 0.5], "y": [-3, -4], "x": [1.5, 2.5]}
    assert [array.dtype.name for array in table.values()] == ["uint8", "float64", "int16", "float32"]


def test_numbers_of_64_bits_and_further_elements_are_told(written: Write) -> None:
    header = BINARY + "element vertex 3\nproperty double x\nproperty double y\n"
    header += "element face 1\nproperty uchar x\nelement edge 0\n"
    rows = np.array([[0.5, 0.25], [0.1, 0.25], [1e300, np.nan]], "<f8").tobytes()
    file = read_ply(written("x.ply", ply(header, rows + b"\0")))
    (change,) = file.changes
    assert (change.action, change.what, change.count) == (Action.LEFT_OUT, "element face", None)
    places = np.zeros((3, 3))
    assert rounded(file.vertices, places, ("x", "y")).count == 2
    assert rounded(file.vertices, places, ("y",)).count == 0
    assert rounded(file.vertices, places + 0.1, ()).count == 3


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"hello", "is not a PLY file"),
        (ply("format ascii 1.0\nelement vertex 1\nproperty float x\n"), "has 0 bytes of text for the 1 numbers"),
        (ply("format ascii 1.0\nelement vertex 1\nproperty float x\n", b"one\n"), "holds words where numbers"),
        (ply("format ascii 1.0\nelement vertex 2\nproperty float x\n", b"1000\n"), "has 1 lines of its element"),
        (ply("format ascii 1.0\nelement vertex 1\nproperty float x\n", b"1 2\n"), "has 2 numbers where 1 belong"),
        (ply("format binary_middle_endian 1.0\nelement vertex 1\n"), "is in the format binary_middle_endian"),
        (ply("element vertex 1\nproperty float x\n"), "does not say in which format it is"),
        (ply(BINARY + "element vertex 99999999999\nproperty float x\n", b"123"), "has 3 bytes of vertices"),
        (ply(BINARY + "element face 99999999999\nproperty list uchar int i\nelement vertex 1\n"), "ends in row 0"),
        (ply(BINARY + "element vertex 9\nproperty float x\n", b"123"), "has 3 bytes of vertices, 9 need 36"),
        (ply(BINARY + "element face 9\n"), "has no vertices"),
        (ply(BINARY + "element vertex many\n"), "has an element vertex of many rows"),
        (ply(BINARY + "element vertex 1\nelement vertex 1\n"), "has the element vertex twice"),
        (ply(BINARY + "element vertex 1\nproperty list float int i\n"), "list float int i, unknown or twice"),
        (ply(BINARY + "element vertex 1\nproperty half x\n"), "has the vertex property half x, unknown or twice"),
        (ply(BINARY + 2 * "property float x\n"), "has the header line 'property float x'"),
        (ply(BINARY + "element vertex 1\n" + 2 * "property float x\n"), "property float x, unknown or twice"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_in_one_line(written: Write, data: bytes, problem: str) -> None:
    path = written("x.ply", data)
    with pytest.raises(InputError) as caught:
        read_ply(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.ply: cannot be read"):
        read_ply(tmp_path / "absent.ply")


def test_columns_stand_side_by_side_and_a_missing_one_is_named() -> None:
    table = {name: np.float32([i, i + 10]) for i, name in enumerate("abc")}
    assert columns(Path("x.ply"), table, ("c", "a")).tolist() == [[2, 0], [12, 10]]
    with pytest.raises(InputError, match=r"x\.ply: has no vertex property d"):
        columns(Path("x.ply"), table, ("a", "d"))


def test_properties_that_are_no_part_of_a_splat_are_named_together_and_normals_are_not() -> None:
    table = dict.fromkeys(("x", "nx", "ny", "label", "f_rest_3", "age"), np.zeros(1, np.float32))
    (change,) = left_over(table, ("x",), ("f_rest_",))
    assert (change.action, change.what, change.count) == (Action.LEFT_OUT, "properties label, age", None)
    assert left_over(table, tuple(table)) == []
