"""Headers of PLY files."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.ply.ply_header import NumberFormat, PlyProperty, read_header

TEXT = """ply
format binary_big_endian 1.0
comment Vertical Axis: z
obj_info made by hand
element face 2
property list uchar int32 vertex_indices
element vertex 3
property float64 x
end_header
"""


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_elements_properties_and_comments_are_read_with_any_line_ends(newline: str, mark: bytes) -> None:
    data = mark + TEXT.replace("\n", newline).encode()
    found = read_header(Path("x.ply"), data + b"rows")
    assert (found.format, found.comments) == (NumberFormat.BIG, ("Vertical Axis: z", "made by hand"))
    assert [(element.name, element.count, element.has_lists) for element in found.elements] == [
        ("face", 2, True),
        ("vertex", 3, False),
    ]
    assert found.elements[0].properties == (PlyProperty("vertex_indices", "i4", "u1"),)
    assert found.elements[1].properties == (PlyProperty("x", "f8"),)
    assert data[found.size :] == b""


def test_a_header_without_an_end_is_none() -> None:
    for data in (b"", b"ply", TEXT.replace("end_header", "end").encode(), TEXT[4:].encode()):
        with pytest.raises(InputError, match="it has no PLY header"):
            read_header(Path("x.ply"), data)
