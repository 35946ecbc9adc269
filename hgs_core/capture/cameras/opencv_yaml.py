"""The part of YAML that OpenCV's FileStorage writes: numbers, words, lists and matrices under names."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.unreadable import unreadable

__all__ = ["OpenCvYaml", "is_opencv_yaml"]

_HEADING = re.compile(r"""^["']?([^\s"':][^"':]*)["']?\s*:\s*(.*)$""")
_NUMBERS = re.compile(r"\[(.*?)\]", re.DOTALL)
_FIELD = re.compile(r"^\s*(rows|cols)\s*:\s*(\d+)\s*$", re.MULTILINE)


def is_opencv_yaml(file: Path) -> bool:
    """Whether the file begins as FileStorage begins it."""
    try:
        with file.open("rb") as opened:
            return opened.read(5) == b"%YAML"
    except OSError:
        return False


class OpenCvYaml:
    """One file; a value is parsed when it is asked for."""

    def __init__(self, file: Path) -> None:
        """Read the file.

        Raises:
            InputError: it is missing or not text.
        """
        self.file = file
        try:
            text = file.read_text("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise unreadable(file, error, "restore the file from its source") from error
        self._blocks: dict[str, str] = {}
        name = ""
        for line in text.splitlines():
            heading = _HEADING.match(line) if line[:1] not in ("%", "#", "-") else None
            if heading:
                name = heading[1].strip()
                self._blocks[name] = heading[2]
            elif name:
                self._blocks[name] += "\n" + line

    def __contains__(self, name: str) -> bool:
        return name in self._blocks

    @property
    def names(self) -> list[str]:
        """The names of all values, in the order of the file."""
        return list(self._blocks)

    def numbers(self, name: str) -> npt.NDArray[np.float64]:
        """Return a matrix [rows, cols], a list [N], or a single number [1].

        Raises:
            InputError: there is no such value, or it is not made of numbers.
        """
        where = f"{self.file}, {name}"
        if name not in self._blocks:
            raise InputError(where, "is missing", "restore the file from its source")
        block = self._blocks[name]
        listed = _NUMBERS.search(block)
        try:
            found = np.array([float(word) for word in (listed[1] if listed else block).replace(",", " ").split()])
        except ValueError as error:
            raise InputError(where, f"is not made of numbers ({error})", "restore the file from its source") from error
        shape = {field: int(count) for field, count in _FIELD.findall(block)}
        if "rows" in shape and "cols" in shape:
            if len(found) != shape["rows"] * shape["cols"]:
                problem = f"has {len(found)} numbers for {shape['rows']} rows of {shape['cols']}"
                raise InputError(where, problem, "restore the file from its source")
            found = found.reshape(shape["rows"], shape["cols"])
        if found.size == 0 or not np.isfinite(found).all():
            raise InputError(where, f"is {found.tolist()}", "calibrate again: it is made of finite numbers")
        return found

    def words(self, name: str) -> list[str]:
        """Return a list of words; empty if there is no such value."""
        block = self._blocks.get(name, "")
        listed = _NUMBERS.search(block)
        parts = listed[1].split(",") if listed else [line.strip()[1:] for line in block.splitlines() if "-" in line]
        return [part.strip().strip("\"'") for part in parts if part.strip()]
