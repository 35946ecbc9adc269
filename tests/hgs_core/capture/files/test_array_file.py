"""Arrays in .npy files: with any header, no more memory is taken than the file has bytes."""

from __future__ import annotations

import io
import pickle
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.files.array_file import read_array


def header(shape: str, kind: str = "<f8", order: bool = False) -> bytes:
    text = f"{{'descr': {kind!r}, 'fortran_order': {order}, 'shape': {shape}, }}"
    text += " " * (-(len(text) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


@pytest.mark.parametrize("kind", ["<f8", ">f8", "<f4", "<f2", "<i4", "|u1", ">u2"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_numbers_of_every_kind_are_read(tmp_path: Path, kind: str, order: str) -> None:
    values = np.arange(12).reshape(3, 4).astype(kind)
    np.save(tmp_path / "a.npy", np.asarray(values, order="F" if order == "F" else "C"))
    found = read_array(tmp_path / "a.npy", "")
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, values)


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (
            header("(1000000000, 17)") + bytes(136),
            r"its header says \(1000000000, 17\) values, 136000000000 bytes, and 136",
        ),
        (header("(99999999999999999999, 17)"), "its header says"),
        (header("(-1, 17)") + bytes(136), "its header says"),
        (header("(1,)", "|O") + pickle.dumps([1]), "holds values of the kind 'object', not numbers"),
        (header("(1,)", "<c16") + bytes(16), "holds values of the kind .*, not numbers"),
        (header("(1,)", "<U4") + bytes(16), "holds values of the kind .*, not numbers"),
        (header("'x'"), "unreadable"),
        (b"\x93NUMPY\x07\x00", "unreadable"),
        (b"", "unreadable"),
        (pickle.dumps([1.0]), "unreadable"),
    ],
)
def test_strange_headers_are_named_and_take_no_memory(tmp_path: Path, data: bytes, problem: str) -> None:
    (tmp_path / "a.npy").write_bytes(data)
    tracemalloc.start()
    with pytest.raises(InputError, match=rf"a\.npy: {problem}"):
        read_array(tmp_path / "a.npy", "restore it")
    assert tracemalloc.get_traced_memory()[1] < 4 << 20
    tracemalloc.stop()


def test_several_arrays_in_one_file_are_none(tmp_path: Path) -> None:
    held = io.BytesIO()
    np.savez(held, a=np.zeros(3))
    (tmp_path / "a.npy").write_bytes(held.getvalue())
    with pytest.raises(InputError, match="unreadable"):
        read_array(tmp_path / "a.npy", "")


def test_a_large_file_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "a.npy").open("wb") as opened:
        opened.truncate(65 << 20)
    with pytest.raises(InputError, match="are the most that are read; restore it"):
        read_array(tmp_path / "a.npy", "restore it")


def test_numbers_beyond_doubles_become_infinite(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array([np.longdouble("1e4000"), np.longdouble(1)]))
    assert read_array(tmp_path / "a.npy", "").tolist() == [np.inf, 1.0]
