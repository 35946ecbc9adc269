"""A scene as a folder that any web server can serve, with the player's page (docs/static.md)."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Collection, Iterator
from pathlib import Path

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback, silent
from hgs_core.codec.format.audio import AudioPiece
from hgs_core.codec.format.folder import (
    CHUNKS,
    MANIFEST,
    THUMBNAIL,
    checked_chunks,
    chunk_id,
    load_manifest,
    stored_sizes,
)
from hgs_core.codec.format.growth import replaces
from hgs_core.codec.format.manifest import FORMAT, ChunkEntry, Manifest
from hgs_core.codec.format.paging import INDEX, paged
from server.publishing import encoded_scene

__all__ = ["PLAYER", "PLAYER_SCRIPT", "publish_to_folder"]

PLAYER = "player"
"""Folder of the player's files, in the built viewer and in what is published."""

PLAYER_SCRIPT = "hgs-player.js"
PAGE = "index.html"

_OURS = frozenset({MANIFEST, INDEX, CHUNKS, THUMBNAIL, PAGE, PLAYER})
_TEMPORARY = re.compile(r"\..+\.[0-9a-f]{12}\.tmp")  # what hgs_core/base/atomic.py leaves when it is killed

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
html, body {{ margin: 0; height: 100%; background: #000; }}
hgs-player {{ display: block; width: 100%; height: 100%; }}
</style>
<script type="module" src="{player}/{script}"></script>
</head>
<body>
<hgs-player src="{source}"{poster} autoplay loop controls></hgs-player>
</body>
</html>
"""


def publish_to_folder(
    run: Path, to: Path, *, player: Path | None, replace: bool = False, progress: ProgressCallback = silent
) -> None:
    """Write the scene of a finished run to the folder `to`, which a web server can then serve as it is.

    Every chunk is decoded before it is written, and the manifest comes last, so whoever finds one finds all that it
    names. Called again, after a kill too, it reuses the chunks that are there and whole. `player` is the folder with
    the built player, None: only the scene's data is written. `replace` allows another scene to take the place of the
    one that is there; that one can be seen until the new manifest is written, and its chunks are removed afterwards.

    Raises:
        InputError: the run has no encoded scene or a damaged one, the player is not built, or `to` holds another
            scene, something else than a scene, or cannot be written. A folder that has no manifest gets none then, and
            a scene that is there stays whole.
    """
    scene, text = encoded_scene(run)
    manifest = load_manifest(scene)
    if player is not None and not (player / PLAYER_SCRIPT).is_file():
        raise InputError(
            player / PLAYER_SCRIPT,
            "is missing: the player is not built",
            "run scripts/install, which builds it, or give --data-only",
        )
    try:
        _refuse_other_contents(to, text, replace)
        _write(scene, to, manifest, text, player, progress)
    except OSError as error:
        raise InputError(to, f"cannot be written ({error})", "give a folder on a disk with room for it") from error


def _refuse_other_contents(to: Path, manifest: bytes, replace: bool) -> None:
    if to.exists() and not to.is_dir():
        raise InputError(to, "is not a folder", "give a new folder")
    found = sorted(path.name for path in to.iterdir() if not _TEMPORARY.fullmatch(path.name)) if to.exists() else []
    if not found:
        return
    if MANIFEST not in found:  # this command was killed here, or the folder is none of ours
        strangers = [name for name in found if name not in _OURS] if CHUNKS in found else found
        if strangers:
            raise InputError(to, f"holds {strangers[0]}, but no scene", "give a new or an empty folder")
        return
    there = (to / MANIFEST).read_bytes()
    if there == manifest or replaces(manifest, there):
        return
    if not _is_scene(there):
        raise InputError(to / MANIFEST, "is not a scene's", "give a new or an empty folder")
    if not replace:
        raise InputError(to, "holds another scene", "give another folder, or --replace")


def _is_scene(manifest: bytes) -> bool:
    try:
        document = json.loads(manifest)
    except (ValueError, RecursionError):
        return False
    return isinstance(document, dict) and document.get("format") == FORMAT


def _write(
    scene: Path, to: Path, manifest: Manifest, text: bytes, player: Path | None, progress: ProgressCallback
) -> None:
    total = len(stored_sizes(manifest)) + 1
    for done, (entry, data) in enumerate(checked_chunks(scene, manifest)):
        progress(Progress("publish", done, total))
        if not _is_whole(to / CHUNKS / entry.id, entry):
            write_bytes(to / CHUNKS / entry.id, data)
    progress(Progress("publish", total - 1, total))
    ready = paged(manifest, json.loads(text))
    for page, data in ready.pages.items():
        write_bytes(to / CHUNKS / page, data)
    if player is not None:
        for name in _files(player):
            write_bytes(to / PLAYER / name, (player / name).read_bytes())
        write_bytes(to / PAGE, _page(manifest, INDEX if ready.pages else MANIFEST).encode())
    if manifest.thumbnail:
        write_bytes(to / THUMBNAIL, (scene / THUMBNAIL).read_bytes())
    write_bytes(to / INDEX, ready.index)
    write_bytes(to / MANIFEST, text)
    _remove_left_over(to, manifest, ready.pages)
    progress(Progress("publish", total, total))


def _files(player: Path) -> Iterator[Path]:
    """Yield the player's files relative to its folder, the script that loads the others last."""
    names = sorted(path.relative_to(player) for path in player.rglob("*") if path.is_file())
    yield from (name for name in names if name != Path(PLAYER_SCRIPT))
    yield Path(PLAYER_SCRIPT)


def _is_whole(file: Path, entry: ChunkEntry | AudioPiece) -> bool:
    return file.is_file() and file.stat().st_size == entry.bytes and chunk_id(file.read_bytes()) == entry.id


def _page(manifest: Manifest, source: str) -> str:
    poster = f' poster="{THUMBNAIL}"' if manifest.thumbnail else ""
    title = html.escape(manifest.title)
    return _PAGE.format(title=title, player=PLAYER, script=PLAYER_SCRIPT, source=source, poster=poster)


def _remove_left_over(to: Path, manifest: Manifest, pages: Collection[str]) -> None:
    """Remove the chunks of a scene that was replaced, and what a kill has left."""
    named = stored_sizes(manifest)
    left = [path for path in (to / CHUNKS).iterdir() if path.name not in named and path.name not in pages]
    left += [path for path in to.iterdir() if _TEMPORARY.fullmatch(path.name)]
    for path in left:
        path.unlink()
    if not manifest.thumbnail:
        (to / THUMBNAIL).unlink(missing_ok=True)
