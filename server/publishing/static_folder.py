"""Publication of a scene as static files, with the player's page (docs/static.md)."""

from __future__ import annotations

import html
import json
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.codec.format.growth import replaces
from hgs_core.codec.format.manifest import FORMAT, Manifest
from hgs_core.codec.format.paging import INDEX, PagedScene, paged
from hgs_core.codec.format.scene_folder import CHUNKS, MANIFEST, THUMBNAIL, checked_chunks, load_manifest, stored_sizes
from jobs.artifacts.publish_run import encoded_scene
from server.routes.poster import Poster

__all__ = ["PLAYER", "PLAYER_SCRIPT", "StaticFile", "StaticTarget", "Transfer", "publish_static"]

PLAYER = "player"
"""Folder of the player's files, in the built viewer and in published scenes."""

PLAYER_SCRIPT = "hgs-player.js"
PAGE = "index.html"
_ICON = "icon.svg"

_OURS = frozenset({MANIFEST, INDEX, CHUNKS, THUMBNAIL, PAGE, PLAYER})
_CODED = frozenset({".br", ".gz"})  # compressed copies made by the build

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
{links}
<style>
html, body, main {{ margin: 0; height: 100%; background: #000; }}
hgs-player {{ display: block; width: 100%; height: 100%; }}
{style}
</style>
<script type="module" src="{player}/{script}"></script>
</head>
<body>
<main><hgs-player src="{source}"{poster} autoplay loop controls></hgs-player></main>
</body>
</html>
"""


class StaticFile(NamedTuple):
    """One file of a published scene."""

    name: str  # path below the target, "chunks/0a1b…"
    data: bytes
    coding: str = ""  # content coding of the data, where a server must declare it: "gzip"


@dataclass(frozen=True)
class Transfer:
    """Counts of written and unchanged files."""

    files: int = 0
    bytes: int = 0
    kept: int = 0  # files already present with the same content

    def __add__(self, other: Transfer) -> Transfer:
        """Return the sum of both."""
        return Transfer(self.files + other.files, self.bytes + other.bytes, self.kept + other.kept)


class StaticTarget(Protocol):
    """The target of a publication; `str` returns its address."""

    kind: str
    """Kind of target in messages: "folder"."""

    takes_codings: bool
    """Whether a file is stored once, with its content coding; otherwise compressed copies lie beside it."""

    def names(self) -> list[str]:
        """Return the top-level names, without remains of a killed publication."""

    def read(self, name: str) -> bytes:
        """Return a file named by `names`."""

    def write(self, files: Iterable[StaticFile]) -> Transfer:
        """Write files atomically, except those already present with the same content.

        All are stored on return.
        """

    def remove(self, name: str) -> None:
        """Remove a file, if it exists."""

    def remove_other_chunks(self, wanted: Collection[str]) -> None:
        """Remove all other chunks, and remains of a killed publication."""


def publish_static(
    run: Path, target: StaticTarget, player: Path | None, replace: bool, progress: ProgressCallback
) -> Transfer:
    """Write the scene of a finished run to the target, as `publish_to_folder` and `publish_to_bucket` do.

    Raises:
        InputError: the run has no encoded scene or a damaged one, the player is not built, or the target contains
            another scene or foreign files.
    """
    scene, text = encoded_scene(run)
    manifest = load_manifest(scene)
    if player is not None and not (player / PLAYER_SCRIPT).is_file():
        raise InputError(
            player / PLAYER_SCRIPT,
            "is missing: the player is not built",
            "run scripts/install, which builds it, or give --data-only",
        )
    _refuse_other_contents(target, text, replace)
    total = len(stored_sizes(manifest)) + 1
    done = target.write(_chunks(scene, manifest, progress))
    progress(Progress("publish", total - 1, total))
    ready = paged(manifest, json.loads(text))
    done += target.write(StaticFile(f"{CHUNKS}/{page}", data) for page, data in ready.pages.items())
    # Each step is complete before the next begins: files come before those that load or name them.
    for files in (*_page(player, target.takes_codings, manifest, ready), *_manifest(scene, manifest, text, ready)):
        done += target.write(files)
    target.remove_other_chunks(stored_sizes(manifest).keys() | ready.pages.keys())
    if not manifest.thumbnail:
        target.remove(THUMBNAIL)
    progress(Progress("publish", total, total))
    return done


def _refuse_other_contents(target: StaticTarget, manifest: bytes, replace: bool) -> None:
    found = target.names()
    if not found:
        return
    empty = f"give a new or an empty {target.kind}"
    if MANIFEST not in found:  # an interrupted publication, or foreign files
        strangers = [name for name in found if name not in _OURS] if CHUNKS in found else found
        if strangers:
            raise InputError(target, f"contains {strangers[0]}, but no scene", empty)
        return
    there = target.read(MANIFEST)
    if there == manifest or replaces(manifest, there):
        return
    if not _is_scene(there):
        raise InputError(f"{target}/{MANIFEST}", "is not the manifest of a scene", empty)
    if not replace:
        raise InputError(target, "contains another scene", f"give another {target.kind}, or --replace")


def _is_scene(manifest: bytes) -> bool:
    try:
        document = json.loads(manifest)
    except (ValueError, RecursionError):
        return False
    return isinstance(document, dict) and document.get("format") == FORMAT


def _chunks(scene: Path, manifest: Manifest, progress: ProgressCallback) -> Iterator[StaticFile]:
    total = len(stored_sizes(manifest)) + 1
    for done, (entry, data) in enumerate(checked_chunks(scene, manifest)):
        progress(Progress("publish", done, total))
        yield StaticFile(f"{CHUNKS}/{entry.id}", data)


def _page(player: Path | None, coded: bool, manifest: Manifest, ready: PagedScene) -> Iterator[Iterable[StaticFile]]:
    """Yield the player's files, then the script that loads them, then the page."""
    if player is None:
        return
    names = sorted(path.relative_to(player).as_posix() for path in player.rglob("*") if path.is_file())
    yield [_player_file(player, name, coded) for name in names if _is_sent(name, coded) and name != PLAYER_SCRIPT]
    yield [_player_file(player, PLAYER_SCRIPT, coded)]
    source = INDEX if ready.pages else MANIFEST
    poster = Poster(THUMBNAIL, manifest.cameras[0].width / manifest.cameras[0].height) if manifest.thumbnail else None
    links = [poster.preload] if poster else []
    if _ICON in names:
        links.append(f'<link rel="icon" href="{PLAYER}/{_ICON}" type="image/svg+xml">')
    # The build's names of the script's imports (web_client/vite.package.config.ts), except its worker: a
    # browser without a cache would request that twice.
    parts = ["player_controls.js", *(["paged_manifest.js"] if ready.pages else [])]
    links += [f'<link rel="modulepreload" href="{PLAYER}/{name}">' for name in parts if name in names]
    if "zstd.wasm" in names:
        links.append(f'<link rel="preload" as="fetch" href="{PLAYER}/zstd.wasm" crossorigin>')
    page = _PAGE.format(
        title=html.escape(manifest.title),
        links="\n".join(links),
        style=poster.style("hgs-player") if poster else "",
        player=PLAYER,
        script=PLAYER_SCRIPT,
        source=source,
        poster=f' poster="{poster.address}"' if poster else "",
    )
    yield [StaticFile(PAGE, page.encode())]


def _is_sent(name: str, coded: bool) -> bool:
    return not coded or Path(name).suffix not in _CODED


def _player_file(player: Path, name: str, coded: bool) -> StaticFile:
    # gzip is accepted by every browser, over plain http, too.
    smaller = player / f"{name}.gz"
    if coded and smaller.is_file():
        return StaticFile(f"{PLAYER}/{name}", smaller.read_bytes(), "gzip")
    return StaticFile(f"{PLAYER}/{name}", (player / name).read_bytes())


def _manifest(scene: Path, manifest: Manifest, text: bytes, ready: PagedScene) -> Iterator[Iterable[StaticFile]]:
    """Yield poster, index and manifest in this order: each may refer to earlier files."""
    if manifest.thumbnail:
        yield [StaticFile(THUMBNAIL, (scene / THUMBNAIL).read_bytes())]
    yield [StaticFile(INDEX, ready.index)]
    yield [StaticFile(MANIFEST, text)]
