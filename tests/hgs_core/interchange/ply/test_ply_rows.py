"""One point cloud in every way that a PLY file may be written: the same splats come back."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hgs_core.base.errors import InputError
from hgs_core.interchange import import_scene
from hgs_core.interchange.ply.ply_table import read_ply
from tests.hgs_core.interchange.scenes import Write, statics

TYPES = {"float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}
NAMES = (
    "x",
    "y",
    "z",
    "scale_0",
    "scale_1",
    "scale_2",
    "rot_0",
    "rot_1",
    "rot_2",
    "rot_3",
    "opacity",
    "f_dc_0",
    "f_dc_1",
    "f_dc_2",
)
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def splat_columns(count: int) -> dict[str, np.ndarray]:
    s = statics(count)
    table = np.concatenate([s.means, s.log_scales, s.quats, s.opacity_logits[:, None], (s.rgb - 0.5) / 0.28209479], 1)
    return dict(zip(NAMES, table.astype(np.float32).T, strict=True))


class Words:
    """Rows in one of the three formats."""

    def __init__(self, kind: str) -> None:
        self.order, self.data = FORMATS[kind], b""

    def row(self, values: list[tuple[str, float]], newline: bytes) -> None:
        if self.order:
            self.data += b"".join(np.array(value, self.order + kind).tobytes() for kind, value in values)
        else:
            words = [str(int(value)) if kind[0] in "iu" else repr(float(value)) for kind, value in values]
            self.data += " ".join(words).encode() + newline


@st.composite
def files(draw: st.DrawFn) -> bytes:
    """A file of six splats: any format, order, types, line ends, further properties, lists and elements."""
    kind = draw(st.sampled_from(sorted(FORMATS)))
    newline = draw(st.sampled_from(["\n", "\r\n"] if kind != "ascii" else ["\n", "\r\n", "\r"]))
    columns = splat_columns(6)
    properties = [(name, draw(st.sampled_from(sorted(TYPES)))) for name in draw(st.permutations(NAMES))]
    at = draw(st.integers(0, len(properties)))
    extra = draw(st.sampled_from(["", "uchar label", "list uchar int neighbours"]))
    comments = draw(st.lists(st.sampled_from(["comment made by hand", "obj_info num_cols 6", "comment end_header"])))
    elements = draw(st.permutations(["vertex", *draw(st.sampled_from([[], ["camera"], ["face"], ["camera", "face"]]))]))
    header, body = ["ply", f"format {kind} 1.0", *comments], Words(kind)
    for element in elements:
        if element == "vertex":
            header.append("element vertex 6" + draw(st.sampled_from(["", "   "])))
            lines = [f"property {type_} {name}" for name, type_ in properties]
            lines[at:at] = [f"property {extra}"] if extra else []
            header += lines
            for i in range(6):
                row = [(TYPES[type_], columns[name][i]) for name, type_ in properties]
                length = draw(st.integers(0, 3)) if extra.startswith("list") else 0
                more = {"": [], "uchar label": [("u1", i)]}.get(extra, [("u1", length), *[("i4", 7)] * length])
                body.row([*row[:at], *more, *row[at:]], newline.encode())
        elif element == "camera":
            header += ["element camera 2", "property float fx", "property double fy"]
            for _ in range(2):
                body.row([("f4", 1.5), ("f8", 2.5)], newline.encode())
        else:
            header += ["element face 3", "property list uchar int vertex_indices"]
            for length in (3, draw(st.integers(0, 5)), 3):
                body.row([("u1", length), *[("i4", 1)] * length], newline.encode())
    return newline.join([*header, "end_header", ""]).encode() + body.data


@given(data=files())
@settings(max_examples=120, deadline=None)
def test_the_same_splats_come_back_whatever_way_they_are_written(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.PLY"
        path.write_bytes(data)
        found = import_scene(path, activated=False).scene.static
    given = statics(6)
    for name, atol in (("means", 0), ("log_scales", 0), ("quats", 0), ("opacity_logits", 0), ("rgb", 1e-6)):
        np.testing.assert_allclose(getattr(found, name), getattr(given, name), rtol=0, atol=atol, err_msg=name)


@given(data=files(), at=st.floats(0, 1), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=120, deadline=None)
def test_a_torn_or_scribbled_file_is_read_or_refused_in_one_line(data: bytes, at: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    torn = bytearray(data[: int(at * len(data))])
    for place in rng.integers(0, max(len(torn), 1), 3) if torn else []:
        torn[place] = rng.integers(256)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.ply"
        path.write_bytes(torn)
        told = ""
        try:
            import_scene(path)
        except InputError as error:
            told = str(error)
    assert "\n" not in told
    assert not told or told.startswith(str(path))


@pytest.mark.parametrize("element", ["vertex 9999999999", "face 9999999999"])
@pytest.mark.parametrize("kind", sorted(FORMATS))
def test_a_count_that_the_file_cannot_hold_takes_no_memory(written: Write, kind: str, element: str) -> None:
    name = "i" if element.startswith("face") else "x"
    header = f"ply\nformat {kind} 1.0\nelement {element}\nproperty float {name}\n"
    header += "element vertex 1\nproperty float x\n" if name == "i" else ""
    with pytest.raises(InputError, match="copy it again"):
        read_ply(written("x.ply", (header + "end_header\n").encode() + b"1 2 3\n"))
