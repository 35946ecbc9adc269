"""How large a benchmark is: splats and pixels, as people write them."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hgs_core.base.errors import InputError

__all__ = ["DEFAULT_SIZES", "Size", "parse_picture_size", "parse_sizes"]

MOST_SPLATS = 10_000_000
MOST_PIXELS = 1 << 26
UNITS = {"": 1, "k": 1_000, "m": 1_000_000}


@dataclass(frozen=True)
class Size:
    """A number of splats and the size of the picture, written like 20k@676x507."""

    splats: int
    width: int  # pixels
    height: int  # pixels

    def __str__(self) -> str:
        count = f"{self.splats // 1000}k" if self.splats % 1000 == 0 else str(self.splats)
        return f"{count}@{self.width}x{self.height}"

    @property
    def affordable(self) -> bool:
        """Whether the torch path, in float64 too, takes seconds and about a gigabyte, not minutes and tens of them."""
        return self.splats <= 20_000 and self.width * self.height <= 676 * 507


DEFAULT_SIZES = tuple(
    Size(splats, width, height)
    for splats in (20_000, 100_000, 500_000)
    for width, height in ((338, 253), (676, 507), (1352, 1014))
)


def parse_sizes(where: str, text: str) -> tuple[Size, ...]:
    """Read sizes separated by commas, each like 20k@676x507; a size that comes twice counts once.

    Args:
        where: what the text is called in an error.
        text: what the user wrote.

    Raises:
        InputError: a text that is no size, or a size of nothing or of too much.
    """
    sizes: dict[Size, None] = {}
    for part in text.split(","):
        match = re.fullmatch(r"(\d{1,9})([km]?)@(\d{1,6})x(\d{1,6})", part.strip().lower(), re.ASCII)
        if match is None:
            raise InputError(where, f"{part.strip()!r} is not SPLATS@WIDTHxHEIGHT", "write for example 20k@676x507")
        count, unit, width, height = match.groups()
        size = Size(int(count) * UNITS[unit], int(width), int(height))
        if not 1 <= size.splats <= MOST_SPLATS:
            raise InputError(where, f"{part.strip()} has {size.splats} splats", f"ask for 1 to {MOST_SPLATS}")
        if not 1 <= size.width * size.height <= MOST_PIXELS:
            raise InputError(where, f"{part.strip()} has {size.width * size.height} pixels", f"at most {MOST_PIXELS}")
        sizes[size] = None
    return tuple(sizes)


def parse_picture_size(where: str, text: str) -> tuple[int, int]:
    """Read the width and height of a picture, like 640x480.

    Raises:
        InputError: a text that is no size, or one of nothing or of too much.
    """
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text.strip().lower(), re.ASCII)
    if match is None:
        raise InputError(where, f"{text.strip()!r} is not WIDTHxHEIGHT", "write for example 640x480")
    width, height = int(match[1]), int(match[2])
    if not 1 <= width * height <= MOST_PIXELS:
        raise InputError(where, f"{text.strip()} has {width * height} pixels", f"ask for 1 to {MOST_PIXELS}")
    return width, height
