"""The file formats that scenes are imported from and exported to: a new one is a module and an entry."""

from __future__ import annotations

import shlex
import zipfile
from collections.abc import Callable
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.interchange.file_format import FileFormat, Reading, ReadSplats
from hgs_core.interchange.fourdgs_file import FOURDGS
from hgs_core.interchange.gltf.gaussian_glb import GLB
from hgs_core.interchange.ply.ply_file import PLY
from hgs_core.interchange.sog_file import SOG
from hgs_core.interchange.sog_writer import META
from hgs_core.interchange.splat_file import SPLAT
from hgs_core.interchange.splatv_file import SPLATV
from hgs_core.interchange.spz.spz_file import SPZ
from hgs_core.interchange.usd_file import USD

__all__ = ["FORMATS", "IMPORTED", "format_of", "frame_format", "read_splats"]

FORMATS = (PLY, SPLAT, SPLATV, SPZ, GLB, FOURDGS, SOG, *USD)

IMPORTED = tuple(one.suffix for one in FORMATS if one.read is not None)
"""The suffixes of files that can be read."""

CONVERTED = (".ksplat", ".lcc", ".lcc2")
"""The suffixes of files that another program makes a .ply of."""

_GZIP, _ZIP = b"\x1f\x8b", b"PK\x03\x04"
_BEGINNINGS = {
    b"ply": (".ply",),
    b"glTF": (".glb",),
    b"NGSP": (".spz",),
    _GZIP: (".spz",),
    _ZIP: (".sog",),
}


def format_of(path: Path, fits: Callable[[FileFormat], bool]) -> FileFormat:
    """Return the format of a file by its suffix, in capitals or not, among those that fit.

    Raises:
        InputError: there is none.
    """
    fitting = {one.suffix: one for one in FORMATS if fits(one)}
    suffix = path.suffix.lower()
    if suffix not in fitting:
        raise InputError(path, f"has the suffix {path.suffix or 'none'!r}", f"give one of {', '.join(fitting)}")
    return fitting[suffix]


def frame_format(name: str) -> FileFormat:
    """Return the format of a folder's frames by its name, `ply` or `sog`.

    Raises:
        InputError: there is none.
    """
    found = {one.suffix[1:]: one for one in FORMATS if one.frame_bytes}
    if name not in found:
        raise InputError("--frames", f"{name!r} is no format of frames", f"give one of {', '.join(found)}")
    return found[name]


def read_splats(path: Path, reading: Reading) -> ReadSplats:
    """Read a file of splats, or a folder that holds one scene.

    Raises:
        InputError: its format is not known or not read, it holds another one than its suffix says, is an archive, or
            is damaged.
    """
    if path.is_dir() or path.name == META:
        assert SOG.read is not None
        return SOG.read(path if path.is_dir() else path.parent, reading)
    if path.suffix.lower() in CONVERTED:
        cure = f"npx @playcanvas/splat-transform {path.name} {path.stem}.ply, and import that"
        raise InputError(path, f"is a file of a kind that is not read ({path.suffix})", cure)
    _check_beginning(path)
    read = format_of(path, lambda one: one.read is not None).read
    assert read is not None
    return read(path, reading)


def _check_beginning(path: Path) -> None:
    """Refuse a file that begins as one of another format does.

    Raises:
        InputError: it does, or is an archive; the message names the suffix that it should have, or the command.
    """
    try:
        with path.open("rb") as file:
            beginning = file.read(8)
    except OSError:
        return  # whoever reads it tells
    suffix = path.suffix.lower()
    if beginning.startswith(_ZIP) and suffix != SOG.suffix and not _is_sog(path):
        raise InputError(path, "is an archive", f"unzip {shlex.quote(path.name)}, and import the file of splats within")
    if beginning.startswith(_GZIP) and suffix == ".gz":
        raise InputError(path, "is compressed", f"gunzip {shlex.quote(path.name)}, and import {path.stem}")
    suffixes = next((found for word, found in _BEGINNINGS.items() if beginning.startswith(word)), None)
    if suffixes is not None and suffix not in (*suffixes, ".4dgs"):
        raise InputError(path, f"begins as a {suffixes[0]} file", f"rename it to {path.stem}{suffixes[0]}")


def _is_sog(path: Path) -> bool:
    """Return whether a zip holds a scene of pictures, at its top or in a folder."""
    try:
        with zipfile.ZipFile(path) as archive:
            return any(name.rpartition("/")[2] == META for name in archive.namelist())
    except (OSError, ValueError, zipfile.BadZipFile):
        return False
