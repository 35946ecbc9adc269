"""The published files and their order; the rest is in test_web_folder.py and test_web_bucket.py."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from pathlib import Path

import pytest

from hgs_core.base.progress import silent
from server.publishing.static_folder import StaticFile, Transfer, publish_static
from tests.growing import write_growing_scene


class Recording:
    """A target in memory that knows in which order files came, those of one call as one."""

    kind = "list"

    def __init__(self, takes_codings: bool = False) -> None:
        self.takes_codings = takes_codings
        self.steps: list[list[StaticFile]] = []

    def names(self) -> list[str]:
        return []

    def read(self, name: str) -> bytes:
        raise FileNotFoundError(name)

    def write(self, files: Iterable[StaticFile]) -> Transfer:
        self.steps.append(list(files))
        return Transfer(len(self.steps[-1]), sum(len(file.data) for file in self.steps[-1]))

    def remove(self, name: str) -> None:
        pass

    def remove_other_chunks(self, wanted: Collection[str]) -> None:
        pass


def published(run: Path, player: Path | None, takes_codings: bool = False) -> Recording:
    target = Recording(takes_codings)
    done = publish_static(run, target, player, False, silent)
    files = [file for step in target.steps for file in step]
    assert done == Transfer(len(files), sum(len(file.data) for file in files))
    return target


def test_nothing_comes_before_what_it_names(player: Path, tmp_path: Path) -> None:
    write_growing_scene(tmp_path / "scene", 2)
    chunks, pages, *others = published(tmp_path, player).steps
    assert {file.name.partition("/")[0] for file in chunks} == {"chunks"}
    assert {file.name.partition("/")[0] for file in pages} == {"chunks"}
    assert [[file.name for file in step] for step in others] == [
        ["player/assets/zstd-1a2b.js", "player/assets/zstd-1a2b.wasm"],
        ["player/hgs-player.js"],
        ["index.html"],
        ["index.hgs"],
        ["manifest.json"],
    ]


@pytest.mark.parametrize("takes_codings", [False, True])
def test_the_player_has_its_compressed_forms_beside_it_or_is_one_of_them(
    scene_folder: Path, player: Path, takes_codings: bool
) -> None:
    (player / "hgs-player.js.gz").write_bytes(b"gzip")
    (player / "hgs-player.js.br").write_bytes(b"brotli")
    target = published(scene_folder, player, takes_codings)
    found = {file.name: (file.data, file.coding) for step in target.steps for file in step}
    script = (player / "hgs-player.js").read_bytes()
    forms = {name: found[name] for name in found if name.startswith("player/hgs-player")}
    assert forms == (
        {"player/hgs-player.js": (b"gzip", "gzip")}
        if takes_codings
        else {
            "player/hgs-player.js": (script, ""),
            "player/hgs-player.js.gz": (b"gzip", ""),
            "player/hgs-player.js.br": (b"brotli", ""),
        }
    )
    assert found["player/assets/zstd-1a2b.js"] == (b"1;", "")
    assert found["manifest.json"][1] == ""
