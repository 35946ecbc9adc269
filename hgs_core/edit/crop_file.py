"""A crop drawn on a scene's page: the box to keep or to empty, and a stretch of time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from hgs_core.base.errors import InputError
from hgs_core.edit.crop import crop
from hgs_core.edit.edit_file import shown
from hgs_core.edit.regions import Box, box_of
from hgs_core.edit.trim import trim
from hgs_core.edit.viewed_scene import Edit, ViewedScene

__all__ = ["CropFile"]

Made = TypeVar("Made")

_LARGEST = 1e12  # world units, seconds
_AGAIN = "draw the box again on the scene's page"


@dataclass(frozen=True, eq=False)
class CropFile:
    """A box with a side to keep, and the stretch of time to keep."""

    file: Path
    box: Box
    inverse: bool  # keeps the outside
    trim: tuple[float, float] | None  # seconds of the scene's clock

    @classmethod
    def of(cls, file: Path, fields: dict[str, Any]) -> CropFile:
        """Read the fields of a file with a checked format.

        Raises:
            InputError: one is malformed; names the file, the field and the value.
        """
        inverse, stretch = fields.get("inverse", False), fields.get("trim")
        if not isinstance(inverse, bool):
            raise InputError(f"{file}: inverse", f"is {shown(inverse)}, not true or false", _AGAIN)
        numbers = _numbers(f"{file}: box", fields.get("box"), (6, 10))
        box = _of_field(f"{file}: box", lambda: box_of(numbers))
        if stretch is None:
            return cls(file, box, inverse, None)
        start, end = _numbers(f"{file}: trim", stretch, (2,))
        return cls(file, box, inverse, (start, end))

    def trimmed(self, viewed: ViewedScene) -> Edit:
        """Keep the stretch of time.

        Raises:
            InputError: as `trim`, at the file's field.
        """
        if self.trim is None:
            return Edit(viewed, ())
        start, end = self.trim
        return _of_field(f"{self.file}: trim", lambda: trim(viewed, start, end))

    def cropped(self, viewed: ViewedScene) -> Edit:
        """Keep one side of the box.

        Raises:
            InputError: as `crop`, at the file's field.
        """
        return _of_field(f"{self.file}: box", lambda: crop(viewed, self.box, inverse=self.inverse))


def _of_field(where: str, make: Callable[[], Made]) -> Made:
    """Name the field in an error that names an option of the command line."""
    try:
        return make()
    except InputError as error:
        raise InputError(where, error.problem, error.cure) from error


def _numbers(where: str, value: Any, counts: tuple[int, ...]) -> list[float]:
    numbers = value if isinstance(value, list) else []
    if len(numbers) not in counts or not all(type(one) in (int, float) and abs(one) <= _LARGEST for one in numbers):
        wanted = " or ".join(map(str, counts))
        raise InputError(where, f"is {shown(value)}, not {wanted} numbers of at most {_LARGEST:g}", _AGAIN)
    return [float(one) for one in numbers]
