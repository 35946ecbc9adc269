"""Scene files: a trained `HybridScene` as .npz, float32, lossless.

Entries: `format` (the version), `segments` [S, 2] (start and end of each segment, seconds), `static.<field>` and
`segment<i>.<field>` with the fields and shapes of `StaticSplats` and `DynamicSplats`. The shape of a motion says how
many coefficients the set has. `background` [3] and `antialiased` say how the scene is drawn; files of earlier versions
have neither, and are read as black and not antialiased.
"""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.base.atomic import replacing
from hgs_core.base.errors import InputError
from hgs_core.scene.motion import COEFFICIENTS
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["load_scene", "save_scene", "save_scene_by_segment"]

FORMAT = 1


def save_scene(path: Path, scene: HybridScene[Floats]) -> None:
    """Write `scene` to `path` atomically; floats are stored as float32.

    Raises:
        OSError: the folder cannot be written.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> scene = hgs.decode_scene(Path("run/scene"))
        >>> hgs.save_scene(Path("decoded.npz"), scene)
        >>> len(hgs.load_scene(Path("decoded.npz")).static) == len(scene.static)
        True
    """
    save_scene_by_segment(path, scene, (segment.dynamic for segment in scene.segments))


def save_scene_by_segment(path: Path, scene: HybridScene[Floats], dynamics: Iterable[DynamicSplats[Floats]]) -> None:
    """Write the file of `save_scene` with other dynamic splats, one set for each segment, held one at a time.

    Raises:
        OSError: the folder cannot be written.
    """
    entries: dict[str, NDArray[Any]] = {
        "format": np.array(FORMAT, np.int64),
        "segments": np.array([(s.start, s.end) for s in scene.segments], np.float64).reshape(-1, 2),
        "background": np.array(scene.background, np.float64),
        "antialiased": np.array(scene.antialiased),
    }
    with replacing(path) as file, zipfile.ZipFile(file, "w") as archive:
        for name, array in entries.items():
            _write(archive, name, array)
        _write_set(archive, "static", scene.static)
        for i, (_, dynamic) in enumerate(zip(scene.segments, dynamics, strict=True)):
            _write_set(archive, f"segment{i}", dynamic)


def _write_set(archive: zipfile.ZipFile, prefix: str, splats: StaticSplats[Floats] | DynamicSplats[Floats]) -> None:
    for name, array in splats.items():
        _write(archive, f"{prefix}.{name}", np.asarray(array, np.float32))


def _write(archive: zipfile.ZipFile, name: str, array: NDArray[Any]) -> None:
    """Write an array as numpy.savez does."""
    with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
        np.lib.format.write_array(cast(Any, entry), array, allow_pickle=False)


def load_scene(path: Path) -> HybridScene[Floats]:
    """Read a file that `save_scene` wrote, with the same bits.

    Raises:
        InputError: the file is missing, unreadable, of another version, or an entry is missing or of the wrong shape.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> scene = hgs.load_scene(Path("run/scene.npz"))
        >>> scene.static.means.shape[1], len(scene.segments)
        (3, 1)
        >>> scene.segments[0].dynamic.motion.shape[1:]  # four coefficients of the position polynomial: x, y, z
        (4, 3)
    """
    try:
        with path.open("rb") as file:
            archive = np.load(file, allow_pickle=False)
            entries = {name: archive[name] for name in archive.files} if hasattr(archive, "files") else {}
    except FileNotFoundError as error:
        raise InputError(path, "no such file", "train a scene first") from error
    except (OSError, ValueError, EOFError, NotImplementedError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(path, f"unreadable scene file ({error})", "train the scene again") from error
    version = _entry(path, entries, "format", (), "i")
    if int(version) != FORMAT:
        raise InputError(path, f"format is {int(version)}, expected {FORMAT}", "use the version that wrote the file")
    spans = _entry(path, entries, "segments", (-1, 2), "f")
    if len(spans) == 0 or not np.isfinite(spans).all() or (spans[:, 1] < spans[:, 0]).any():
        raise InputError(path, "segments are not spans of time with a start and a later end", "train the scene again")
    static = StaticSplats(*_arrays(path, entries, "static", StaticSplats.empty()))
    segments = tuple(
        Segment(
            float(start),
            float(end),
            DynamicSplats(*_arrays(path, entries, f"segment{i}", _model(entries, f"segment{i}"))),
        )
        for i, (start, end) in enumerate(spans)
    )
    drawn_as: dict[str, Any] = {}
    if "background" in entries:
        red, green, blue = map(float, _entry(path, entries, "background", (3,), "f"))
        drawn_as["background"] = red, green, blue
    if "antialiased" in entries:
        drawn_as["antialiased"] = bool(_entry(path, entries, "antialiased", (), "b"))
    return HybridScene(static, segments, **drawn_as)


def _arrays(
    path: Path, entries: Mapping[str, NDArray[Any]], prefix: str, empty: StaticSplats[Floats] | DynamicSplats[Floats]
) -> list[Floats]:
    """Collect the arrays of one set; their row shapes are those of `empty`, and their lengths agree."""
    count = -1
    arrays: list[Floats] = []
    for name, model in empty.items():
        array = _entry(path, entries, f"{prefix}.{name}", (count, *model.shape[1:]), "f")
        arrays.append(np.asarray(array, np.float32))
        count = len(array)
    return arrays


def _model(entries: Mapping[str, NDArray[Any]], prefix: str) -> DynamicSplats[Floats]:
    """Return an empty set with as many coefficients of motion as the file's, if there may be so many."""
    shape = entries[f"{prefix}.motion"].shape if f"{prefix}.motion" in entries else ()
    return DynamicSplats.empty(shape[1]) if len(shape) == 3 and shape[1] in COEFFICIENTS else DynamicSplats.empty()


def _entry(
    path: Path, entries: Mapping[str, NDArray[Any]], name: str, shape: tuple[int, ...], kind: str
) -> NDArray[Any]:
    """Return an entry of the given kind of number and shape, in which -1 stands for any length."""
    if name not in entries:
        raise InputError(path, f"has no entry {name}", "give the scene.npz of a run")
    array = entries[name]
    fits = len(array.shape) == len(shape) and all(w in (-1, h) for h, w in zip(array.shape, shape, strict=True))
    if array.dtype.kind != kind or not fits:
        wanted = "x".join("N" if n == -1 else str(n) for n in shape) or "scalar"
        raise InputError(path, f"entry {name} is {array.dtype} {array.shape}, expected {wanted} of kind {kind!r}")
    return array
