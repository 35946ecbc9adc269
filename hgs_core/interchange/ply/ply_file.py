"""The .ply files of 3DGS, compressed or not, and of STGS, told apart by their properties."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from hgs_core.interchange.antialiasing_note import noted
from hgs_core.interchange.file_format import FileFormat, Reading, ReadSplats
from hgs_core.interchange.ply.compressed_ply import is_compressed, unpacked
from hgs_core.interchange.ply.gaussian_ply import GAUSSIAN_BYTES, gaussian_ply, gaussian_splats
from hgs_core.interchange.ply.ply_table import read_ply
from hgs_core.interchange.ply.spacetime_ply import is_spacetime, spacetime_ply, spacetime_splats

__all__ = ["PLY"]


def _read(path: Path, reading: Reading) -> ReadSplats:
    file = read_ply(path)
    table = file.vertices
    antialiased = noted(file.comments)
    if is_compressed(table):
        table = unpacked(path, table, file.chunks)
    if is_compressed(file.vertices) or antialiased is not None:  # written by programs that know the format
        reading = dataclasses.replace(reading, activated=False)
    found = (spacetime_splats if is_spacetime(table) else gaussian_splats)(path, table, reading)
    return dataclasses.replace(found, antialiased=antialiased, changes=(*file.changes, *found.changes))


PLY = FileFormat(
    ".ply",
    read=_read,
    write_still=gaussian_ply,
    frame_bytes=GAUSSIAN_BYTES,
    write_moving=lambda static, dynamic, cameras, antialiased: spacetime_ply(static, dynamic, antialiased),
)
