from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urljoin
from urllib.request import urlopen

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.paged_manifest import PagedManifest, read_index
from hgs_core.codec.format.scene_folder import chunk_bytes, load_manifest
from server.publishing.web_folder import publish_to_folder
from tests.growing import write_growing_scene
from tests.server.conftest import Killed, killed_after


def tree(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


def test_the_folder_is_complete(scene_folder: Path, player: Path, tmp_path: Path) -> None:
    publish_to_folder(scene_folder, tmp_path / "web", player=player)
    scene = scene_folder / "scene"
    data = {name: (scene / name).read_bytes() for name in tree(scene)}
    manifest = json.loads(data["manifest.json"])
    files = {f"player/{name}": (player / name).read_bytes() for name in tree(player)}
    found = {name: (tmp_path / "web" / name).read_bytes() for name in tree(tmp_path / "web")}
    page = found.pop("index.html").decode()
    assert read_index(found.pop("index.hgs")) == manifest
    assert found == data | files
    assert 'src="manifest.json"' in page
    assert "<title>Studio</title>" in page


def test_data_only_writes_neither_player_nor_page(scene_folder: Path, tmp_path: Path) -> None:
    publish_to_folder(scene_folder, tmp_path / "web", player=None)
    assert tree(tmp_path / "web") == tree(scene_folder / "scene") | {"index.hgs"}


def test_a_player_that_is_not_built_is_told_before_anything_is_written(scene_folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"hgs-player\.js: is missing.*scripts/install.*--data-only"):
        publish_to_folder(scene_folder, tmp_path / "web", player=tmp_path / "viewer" / "player")
    assert not (tmp_path / "web").exists()


@pytest.mark.parametrize("written", [0, 1, 3, 5])
def test_a_kill_leaves_no_manifest_and_the_next_call_completes_the_folder(
    scene_folder: Path, player: Path, tmp_path: Path, written: int
) -> None:
    web = tmp_path / "web"
    with pytest.raises(Killed):
        publish_to_folder(scene_folder, web, player=player, progress=killed_after(written))
    assert len(list((web / "chunks").glob("*"))) == written
    assert not (web / "manifest.json").exists()
    if written:
        (web / "chunks" / ".abc.0123456789ab.tmp").write_bytes(b"half")
        (web / ".index.html.0123456789ab.tmp").write_bytes(b"half")
    publish_to_folder(scene_folder, web, player=player)
    assert {name for name in tree(web) if not name.startswith("player/")} == tree(scene_folder / "scene") | {
        "index.hgs",
        "index.html",
    }


def test_publishing_again_writes_only_damaged_chunks_anew(scene_folder: Path, player: Path, tmp_path: Path) -> None:
    web = tmp_path / "web"
    publish_to_folder(scene_folder, web, player=player)
    whole, damaged = sorted((web / "chunks").iterdir())[:2]
    size = damaged.stat().st_size
    damaged.write_bytes(b"x" * size)
    before = whole.stat().st_ino, damaged.stat().st_ino
    publish_to_folder(scene_folder, web, player=player)
    assert whole.stat().st_ino == before[0]
    assert damaged.stat().st_ino != before[1]
    assert damaged.read_bytes() == (scene_folder / "scene" / "chunks" / damaged.name).read_bytes()


def test_another_scene_is_refused_unless_it_may_be_replaced(
    scene_folder: Path, other_scene: Path, tmp_path: Path
) -> None:
    web = tmp_path / "web"
    publish_to_folder(scene_folder, web, player=None)
    before = tree(web)
    with pytest.raises(InputError, match="contains another scene; give another folder, or --replace"):
        publish_to_folder(other_scene, web, player=None)
    assert tree(web) == before
    publish_to_folder(other_scene, web, player=None, replace=True)
    assert tree(web) == tree(other_scene / "scene") | {"index.hgs"} < before


def test_pages_of_a_manifest_lie_among_the_chunks_and_go_when_others_take_their_place(
    player: Path, tmp_path: Path
) -> None:
    run, web = tmp_path / "run", tmp_path / "web"
    for segments in (1, 2):
        manifest = write_growing_scene(run / "scene", segments)
        publish_to_folder(run, web, player=player)
        paged = PagedManifest(read_index((web / "index.hgs").read_bytes()))
        (page,) = paged.pages
        paged.add(page.id, (web / "chunks" / page.id).read_bytes())
        assert paged.manifest.to_json() == json.loads(manifest)
        named = {chunk.id for chunk in paged.manifest.chunks} | {page.id}
        assert {file.name for file in (web / "chunks").iterdir()} == named
    assert 'src="index.hgs"' in (web / "index.html").read_text()


def test_a_scene_that_has_grown_needs_no_leave_to_replace_what_it_was(tmp_path: Path) -> None:
    run, site = tmp_path / "run", tmp_path / "site"
    for segments in (1, 3):
        manifest = write_growing_scene(run / "scene", segments)
        publish_to_folder(run, site, player=None)
        assert (site / "manifest.json").read_bytes() == manifest
    write_growing_scene(run / "scene", 2)
    with pytest.raises(InputError, match="another scene"):
        publish_to_folder(run, site, player=None)


def test_while_a_scene_is_replaced_the_old_one_is_whole(scene_folder: Path, other_scene: Path, tmp_path: Path) -> None:
    web = tmp_path / "web"
    publish_to_folder(other_scene, web, player=None)
    with pytest.raises(Killed):
        publish_to_folder(scene_folder, web, player=None, replace=True, progress=killed_after(5))
    manifest = load_manifest(web)
    assert manifest.title == "<Other> & more"
    for entry in manifest.chunks:
        chunk_bytes(web, entry)


@pytest.mark.parametrize("replace", [False, True])
@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("dear.jpg", b"photo"),
        ("index.html", b"a page"),
        ("manifest.json", b'{"name": "an app"}'),
        ("manifest.json", b"{"),
    ],
)
def test_a_folder_of_something_else_is_never_touched(
    scene_folder: Path, tmp_path: Path, name: str, content: bytes, replace: bool
) -> None:
    web = tmp_path / "web"
    web.mkdir()
    (web / name).write_bytes(content)
    with pytest.raises(InputError, match=r"give a new or an empty folder"):
        publish_to_folder(scene_folder, web, player=None, replace=replace)
    assert {path: path.read_bytes() for path in web.iterdir()} == {web / name: content}


def test_a_file_of_that_name_is_refused(scene_folder: Path, tmp_path: Path) -> None:
    (tmp_path / "web").write_bytes(b"")
    with pytest.raises(InputError, match="is not a folder"):
        publish_to_folder(scene_folder, tmp_path / "web", player=None)


def test_a_broken_scene_is_written_without_manifest_and_page(scene_folder: Path, player: Path, tmp_path: Path) -> None:
    entry = load_manifest(scene_folder / "scene").chunks[-1]
    (scene_folder / "scene" / "chunks" / entry.id).unlink()
    with pytest.raises(InputError, match="cannot be read"):
        publish_to_folder(scene_folder, tmp_path / "web", player=player)
    assert {name.split("/")[0] for name in tree(tmp_path / "web")} == {"chunks"}


def test_a_broken_scene_leaves_the_one_that_it_should_replace(
    scene_folder: Path, other_scene: Path, tmp_path: Path
) -> None:
    web = tmp_path / "web"
    publish_to_folder(other_scene, web, player=None)
    document = json.loads((scene_folder / "scene" / "manifest.json").read_text())
    document["static"][1]["splats"] += 1
    document["totals"]["splats_static"] += 1
    (scene_folder / "scene" / "manifest.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=r"splats, the manifest says.*hgs encode RUN"):
        publish_to_folder(scene_folder, web, player=None, replace=True)
    manifest = load_manifest(web)
    assert manifest.title == "<Other> & more"
    for entry in manifest.chunks:
        chunk_bytes(web, entry)


def test_a_title_and_a_missing_picture_leave_a_sound_page(other_scene: Path, player: Path, tmp_path: Path) -> None:
    publish_to_folder(other_scene, tmp_path / "web", player=player)
    page = (tmp_path / "web" / "index.html").read_text()
    assert "<title>&lt;Other&gt; &amp; more</title>" in page
    assert "poster" not in page


class _Links(HTMLParser):
    """A collector of a page's files."""

    def __init__(self) -> None:
        super().__init__()
        self.found: dict[str, str] = {}

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found |= {f"{tag}.{name}": value for name, value in attributes if name in ("src", "poster") and value}


@pytest.fixture
def address(scene_folder: Path, player: Path, tmp_path: Path) -> Iterator[str]:
    """The address of the published files on Python's own web server."""
    publish_to_folder(scene_folder, tmp_path / "web", player=player)

    class Silent(SimpleHTTPRequestHandler):
        def log_message(self, format: str, *arguments: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Silent, directory=str(tmp_path / "web"))) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()
        thread.join()


def test_a_plain_web_server_serves_all_that_the_page_and_the_manifest_name(
    address: str, scene_folder: Path, manifest: bytes
) -> None:
    def get(url: str) -> tuple[bytes, str]:
        with urlopen(url, timeout=30) as answer:
            return answer.read(), answer.headers["Content-Type"]

    page, media_type = get(address)
    assert media_type == "text/html"
    links = _Links()
    links.feed(page.decode())
    assert set(links.found) == {"script.src", "hgs-player.src", "hgs-player.poster"}
    assert get(urljoin(address, links.found["script.src"]))[1] in ("text/javascript", "application/javascript")
    assert get(urljoin(address, links.found["hgs-player.poster"])) == (b"jpeg", "image/jpeg")
    source = urljoin(address, links.found["hgs-player.src"])
    assert get(source) == (manifest, "application/json")
    for entry in load_manifest(scene_folder / "scene").chunks:
        assert get(urljoin(source, f"chunks/{entry.id}"))[0] == chunk_bytes(scene_folder / "scene", entry)
