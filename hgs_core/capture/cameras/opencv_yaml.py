"""The part of YAML that OpenCV's FileStorage writes: numbers, words, lists and matrices under names."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.files.text_file import begins_with, read_text

__all__ = ["OpenCvYaml", "is_opencv_yaml"]

# No part of a pattern matches what the next one may begin with: files come from strangers.
_HEADING = re.compile(r"""^["']?([^\s"':][^"':]*)(?:["'][ \t]*)?:(.*)$""")
_FIELD = re.compile(r"^[ \t]*(rows|cols)[ \t]*:[ \t]*(\d{1,9})[ \t]*$", re.MULTILINE)


def is_opencv_yaml(file: Path) -> bool:
    """Whether the file begins as FileStorage begins it."""
    return begins_with(file, "%YAML")


class OpenCvYaml:
    """One file; a value is parsed when it is asked for."""

    def __init__(self, file: Path) -> None:
        """Read the file.

        Raises:
            InputError: it is missing or not text.
        """
        self.file = file
        blocks: dict[str, list[str]] = {}
        name = ""
        for line in read_text(file, "restore the file from its source").split("\n"):
            heading = _HEADING.match(line) if line[:1] not in ("%", "#", "-") else None
            if heading:
                name = heading[1].strip()
                if name in blocks:
                    raise InputError(file, f"{shown(name)} is there twice", "keep one of them")
                blocks[name] = [heading[2]]
            elif name:
                blocks[name].append(line)
        self._blocks = {name: "\n".join(lines) for name, lines in blocks.items()}

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
        listed = _listed(block)
        try:
            found = np.array([float(word) for word in (block if listed is None else listed).replace(",", " ").split()])
        except ValueError as error:
            raise InputError(where, f"is not made of numbers ({error})", "restore the file from its source") from error
        shape = {field: int(count) for field, count in _FIELD.findall(block)}
        if "rows" in shape and "cols" in shape:
            if len(found) != shape["rows"] * shape["cols"]:
                problem = f"has {len(found)} numbers for {shape['rows']} rows of {shape['cols']}"
                raise InputError(where, problem, "restore the file from its source")
            found = found.reshape(shape["rows"], shape["cols"])
        if found.size == 0 or not np.isfinite(found).all():
            raise InputError(where, f"is {shown(found.tolist())}", "calibrate again: it is made of finite numbers")
        return found

    def words(self, name: str) -> list[str]:
        """Return a list of words; empty if there is no such value."""
        block = self._blocks.get(name, "")
        listed = _listed(block)
        lines = block.split("\n")
        parts = [line.strip()[1:] for line in lines if "-" in line] if listed is None else listed.split(",")
        return [part.strip().strip("\"'") for part in parts if part.strip()]


def _listed(block: str) -> str | None:
    """Return the text in the first brackets."""
    start = block.find("[")
    end = block.find("]", start)
    return block[start + 1 : end] if 0 <= start < end else None
