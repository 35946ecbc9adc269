"""Arrays of numbers in NumPy's .npy files: the header is compared with the file before memory is taken for it."""

from __future__ import annotations

import math
from pathlib import Path
from tokenize import TokenError

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.files.unreadable import unreadable

__all__ = ["read_array"]

_MOST_BYTES = 64 << 20  # a million cameras of LLFF take 130 MiB, and no rig has so many
_NUMBERS = "fiu"  # the kinds of values that are real numbers


def read_array(file: Path, cure: str) -> npt.NDArray[np.float64]:
    """Return the array of a file in doubles; numbers beyond them become infinite.

    Raises:
        InputError: the file is missing, larger than 64 MiB, no .npy file, shorter than its header says, or holds
            something else than real numbers; `cure` is for damage.
    """
    try:
        size = file.stat().st_size
        if size > _MOST_BYTES:
            raise InputError(file, f"has {size} bytes, and {_MOST_BYTES} are the most that are read", cure)
        with file.open("rb") as opened:
            version = np.lib.format.read_magic(opened)
            if version not in ((1, 0), (2, 0)):
                raise ValueError(f"its format is {version[0]}.{version[1]}")
            header = np.lib.format
            read_header = header.read_array_header_1_0 if version == (1, 0) else header.read_array_header_2_0
            shape, in_columns, kind = read_header(opened)
            if kind.kind not in _NUMBERS:
                problem = f"holds values of the kind {shown(str(kind))}, not numbers"
                raise InputError(file, problem, "save it as an array of doubles")
            announced, there = math.prod(shape) * kind.itemsize, size - opened.tell()
            if announced > there or min(shape, default=0) < 0:
                problem = f"its header says {shape} values, {announced} bytes, and {there} bytes follow"
                raise InputError(file, problem, cure)
            data = opened.read(announced)
    except (OSError, ValueError, EOFError, TypeError, SyntaxError, RecursionError, OverflowError, TokenError) as error:
        if isinstance(error, InputError):
            raise
        raise unreadable(file, error, cure) from error
    values = np.frombuffer(data, kind).reshape(shape, order="F" if in_columns else "C")
    with np.errstate(over="ignore", invalid="ignore"):
        return values.astype(np.float64)
