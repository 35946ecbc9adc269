"""What there is to know of one layout of captures on disk. Each loader's module describes its own."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from hgs_core.capture.recording import Recording

__all__ = ["Layout", "Outline"]


@dataclass(frozen=True)
class Outline:
    """What can be told of a capture without decoding a picture; it is not checked as `load` checks it."""

    cameras: tuple[str, ...]  # their names, in the order of the capture
    frames: int | None = None  # None: not told without reading more
    seconds: float | None = None  # that the frames last, as far as that is known


@dataclass(frozen=True)
class Layout:
    """A way in which captures lie on disk."""

    name: str  # for people
    files: str  # what a folder of this layout holds, for people
    recognises: Callable[[Iterable[str]], bool]  # whether a folder with files of these names is one
    load: Callable[[Path, Path | None], Recording]  # of a folder, and of masks in place of its own
    outline: Callable[[Path], Outline]  # of a folder; it reads little, and raises InputError where that is damaged
