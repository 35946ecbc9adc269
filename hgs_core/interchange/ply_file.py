"""The .ply files of 3DGS and of STGS, told apart by their properties."""

from __future__ import annotations

from pathlib import Path

from hgs_core.interchange.file_format import FileFormat, ReadSplats
from hgs_core.interchange.gaussian_ply import gaussian_ply, gaussian_splats
from hgs_core.interchange.ply_table import read_ply
from hgs_core.interchange.spacetime_ply import is_spacetime, spacetime_ply, spacetime_splats

__all__ = ["PLY"]


def _read(path: Path) -> ReadSplats:
    table, changes = read_ply(path)
    if is_spacetime(table):
        static, dynamic, more = spacetime_splats(path, table)
        return ReadSplats(static, (dynamic,), lasts=True, changes=(*changes, *more))
    static, more = gaussian_splats(path, table)
    return ReadSplats(static, changes=(*changes, *more))


PLY = FileFormat(
    ".ply",
    read=_read,
    write_still=lambda splats, antialiased: gaussian_ply(splats),
    write_moving=lambda static, dynamic, cameras: spacetime_ply(static, dynamic),
)
