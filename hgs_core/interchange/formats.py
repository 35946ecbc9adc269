"""The file formats that scenes are imported from and exported to: a new one is a module and an entry."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.interchange.file_format import FileFormat
from hgs_core.interchange.fourdgs_file import FOURDGS
from hgs_core.interchange.gaussian_glb import GLB
from hgs_core.interchange.ply_file import PLY
from hgs_core.interchange.splat_file import SPLAT
from hgs_core.interchange.splatv_file import SPLATV
from hgs_core.interchange.spz_file import SPZ

__all__ = ["FORMATS", "IMPORTED", "format_of"]

FORMATS = (PLY, SPLAT, SPLATV, SPZ, GLB, FOURDGS)

IMPORTED = tuple(one.suffix for one in FORMATS if one.read is not None)
"""The suffixes of files that can be read."""


def format_of(path: Path, fits: Callable[[FileFormat], bool]) -> FileFormat:
    """Return the format of a file by its suffix, among those that fit.

    Raises:
        InputError: there is none.
    """
    fitting = {one.suffix: one for one in FORMATS if fits(one)}
    if path.suffix not in fitting:
        raise InputError(path, f"has the suffix {path.suffix or 'none'!r}", f"give one of {', '.join(fitting)}")
    return fitting[path.suffix]
