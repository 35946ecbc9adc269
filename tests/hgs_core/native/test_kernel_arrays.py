from __future__ import annotations

import ctypes

import numpy as np
import pytest

from hgs_core.native.kernel_arrays import address, pointers


def test_the_address_is_where_the_first_number_lies() -> None:
    array = np.array([[1.5, 2.5], [3.5, 4.5]], np.float32)
    assert ctypes.c_float.from_address(address("array", array, (2, 2))).value == 1.5
    assert ctypes.c_float.from_address(address("array", array[1:], (1, 2))).value == 3.5


@pytest.mark.parametrize(
    ("array", "got"),
    [
        (np.zeros((3, 2), np.float32), r"got float32 \(3, 2\)$"),
        (np.zeros((2, 3), np.float64), r"got float64 \(2, 3\)$"),
        (np.zeros((3, 2), np.float32).T, r"got float32 \(2, 3\), not contiguous$"),
    ],
)
def test_what_the_kernels_would_misread_is_refused(array: np.ndarray, got: str) -> None:
    with pytest.raises(ValueError, match=r"means must be a contiguous float32 array of shape \(2, 3\), " + got):
        address("means", array, (2, 3))


def test_fields_of_pointers_hold_addresses() -> None:
    class Two(ctypes.Structure):
        _fields_ = pointers(("first", "second"))

    assert ctypes.sizeof(Two) == 2 * ctypes.sizeof(ctypes.c_void_p)
    assert (Two(first=16).first, Two(first=16).second) == (16, None)
