"""Publishing into a bucket of a server that speaks S3 (moto's)."""

from __future__ import annotations

import json
import re
import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import obstore
import pytest
from obstore.store import ObjectStore

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress
from hgs_core.codec.format.paged_manifest import PagedManifest, read_index
from hgs_core.codec.format.scene_folder import MANIFEST, chunk_bytes, load_manifest
from jobs.home.object_store import open_object_store
from server.publishing.static_folder import Transfer
from server.publishing.web_bucket import publish_to_bucket
from tests.conftest import REPOSITORY
from tests.growing import write_growing_scene
from tests.jobs.modules.flaky_proxy import FlakyProxy
from tests.jobs.modules.s3_server import S3Server
from tests.server.conftest import Killed, killed_after


@pytest.fixture
def store(s3_url: str) -> ObjectStore:
    return open_object_store(s3_url)


def contents(store: ObjectStore) -> dict[str, bytes]:
    names = [item["path"] for page in obstore.list(store) for item in page]
    return {name: bytes(obstore.get(store, name).bytes()) for name in names}


def whole_scene(store: ObjectStore, folder: Path) -> str:
    """Copy the published files to a folder, read all chunks named by its manifest, and return its title."""
    for name, data in contents(store).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    manifest = load_manifest(folder)
    for entry in manifest.chunks:
        chunk_bytes(folder, entry)
    return manifest.title


def test_files_have_the_headers_that_browsers_and_caches_need(
    scene_folder: Path, player: Path, s3_url: str, store: ObjectStore
) -> None:
    (player / "assets" / "zstd-1a2b.js.gz").write_bytes(b"gzip")
    done = publish_to_bucket(scene_folder, s3_url, player=player)
    found = contents(store)
    scene = scene_folder / "scene"
    data = {path.relative_to(scene).as_posix(): path.read_bytes() for path in scene.rglob("*") if path.is_file()}
    assert {name: found[name] for name in data} == data
    assert read_index(found["index.hgs"]) == json.loads(data[MANIFEST])
    assert b'src="manifest.json"' in found["index.html"]
    assert done == Transfer(len(found), sum(map(len, found.values())))
    headers = {
        name: tuple(
            obstore.get(store, name).attributes.get(key)
            for key in ("Content-Type", "Cache-Control", "Content-Encoding")
        )
        for name in found
    }
    chunk = ("application/octet-stream", "public, max-age=31536000, immutable", None)
    assert headers == dict.fromkeys((name for name in found if name.startswith("chunks/")), chunk) | {
        "manifest.json": ("application/json", "no-cache", None),
        "index.hgs": ("application/octet-stream", "no-cache", None),
        "thumbnail.jpg": ("image/jpeg", "no-cache", None),
        "index.html": ("text/html; charset=utf-8", "no-cache", None),
        "player/hgs-player.js": ("text/javascript; charset=utf-8", "no-cache", None),
        "player/assets/zstd-1a2b.js": ("text/javascript; charset=utf-8", "no-cache", "gzip"),
        "player/assets/zstd-1a2b.wasm": ("application/wasm", "no-cache", None),
    }


def test_what_is_there_is_not_sent_again(
    scene_folder: Path, player: Path, s3_url: str, store: ObjectStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = publish_to_bucket(scene_folder, s3_url, player=player)
    before = contents(store)
    damaged = next(name for name in before if name.startswith("chunks/"))
    obstore.put(store, damaged, bytes(len(before[damaged])))
    assert publish_to_bucket(scene_folder, s3_url, player=player) == Transfer(1, len(before[damaged]), first.files - 1)
    assert contents(store) == before

    def put(*arguments: Any, **options: Any) -> None:
        raise AssertionError(arguments)

    monkeypatch.setattr(obstore, "put", put)
    assert publish_to_bucket(scene_folder, s3_url, player=player) == Transfer(kept=first.files)


def test_an_object_whose_etag_is_not_its_md5_is_read(scene_folder: Path, s3_url: str, store: ObjectStore) -> None:
    first = publish_to_bucket(scene_folder, s3_url, player=None)
    obstore.put(store, MANIFEST, (scene_folder / "scene" / MANIFEST).read_bytes(), use_multipart=True)
    assert (obstore.head(store, MANIFEST)["e_tag"] or "").endswith('-1"')
    assert publish_to_bucket(scene_folder, s3_url, player=None) == Transfer(kept=first.files)


@pytest.mark.parametrize("written", [0, 3, 5])
def test_a_kill_leaves_no_manifest_and_the_next_call_completes_the_scene(
    scene_folder: Path, s3_url: str, store: ObjectStore, tmp_path: Path, written: int
) -> None:
    with pytest.raises(Killed):
        publish_to_bucket(scene_folder, s3_url, player=None, progress=killed_after(written))
    found = contents(store)
    assert len(found) == written
    assert all(name.startswith("chunks/") for name in found)
    assert publish_to_bucket(scene_folder, s3_url, player=None).kept == written
    assert whole_scene(store, tmp_path / "copy") == "Studio"


def test_while_a_scene_is_replaced_the_old_one_is_whole(
    scene_folder: Path, other_scene: Path, s3_url: str, store: ObjectStore, tmp_path: Path
) -> None:
    publish_to_bucket(other_scene, s3_url, player=None)
    with pytest.raises(InputError, match="contains another scene; give another prefix, or --replace"):
        publish_to_bucket(scene_folder, s3_url, player=None)
    with pytest.raises(Killed):
        publish_to_bucket(scene_folder, s3_url, player=None, replace=True, progress=killed_after(5))
    assert whole_scene(store, tmp_path / "old") == "<Other> & more"
    publish_to_bucket(scene_folder, s3_url, player=None, replace=True)
    assert whole_scene(store, tmp_path / "new") == "Studio"
    publish_to_bucket(other_scene, s3_url, player=None, replace=True)
    chunks = {f"chunks/{path.name}" for path in (other_scene / "scene" / "chunks").iterdir()}
    assert contents(store).keys() == chunks | {MANIFEST, "index.hgs"}


def test_a_scene_that_has_grown_replaces_what_it_was(s3_url: str, store: ObjectStore, tmp_path: Path) -> None:
    for segments in (1, 3):
        manifest = write_growing_scene(tmp_path / "run" / "scene", segments)
        publish_to_bucket(tmp_path / "run", s3_url, player=None)
        found = contents(store)
        assert found[MANIFEST] == manifest
        paged = PagedManifest(read_index(found["index.hgs"]))
        named = {chunk.id for chunk in load_manifest(tmp_path / "run" / "scene").chunks} | {p.id for p in paged.pages}
        assert {name for name in found if name.startswith("chunks/")} == {f"chunks/{name}" for name in named}
    write_growing_scene(tmp_path / "run" / "scene", 2)
    with pytest.raises(InputError, match="another scene"):
        publish_to_bucket(tmp_path / "run", s3_url, player=None)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("dear.jpg", "contains dear.jpg, but no scene"),
        ("manifest.json", "manifest.json: is not the manifest of a scene"),
    ],
)
def test_a_prefix_of_something_else_is_never_touched(
    scene_folder: Path, s3_url: str, store: ObjectStore, name: str, problem: str
) -> None:
    obstore.put(store, name, b"dear")
    obstore.put(open_object_store(f"{s3_url}-too"), "neighbour", b"none of this")
    with pytest.raises(InputError, match=rf"{problem}; give a new or an empty prefix"):
        publish_to_bucket(scene_folder, s3_url, player=None, replace=True)
    assert contents(store) == {name: b"dear"}


def test_a_folder_that_a_console_has_made_is_empty(s3_server: S3Server, scene_folder: Path, s3_url: str) -> None:
    urlopen(Request(f"{s3_server.address}/bucket/{s3_url.rpartition('/')[2]}/", method="PUT"), timeout=30).close()
    assert publish_to_bucket(scene_folder, s3_url, player=None).files


def test_a_fault_that_passes_is_tried_again(
    s3_server: S3Server,
    scene_folder: Path,
    s3_url: str,
    store: ObjectStore,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    proxy = FlakyProxy(int(s3_server.address.rpartition(":")[2]))
    monkeypatch.setenv("AWS_ENDPOINT", proxy.address)

    def progress(report: Progress) -> None:
        if report.done == 2:
            proxy.refuse()
            threading.Timer(0.2, proxy.pass_on).start()

    try:
        publish_to_bucket(scene_folder, s3_url, player=None, progress=progress)
    finally:
        proxy.refuse()
    assert whole_scene(store, tmp_path / "copy") == "Studio"


def test_whoever_may_read_the_prefix_reads_the_scene(s3_server: S3Server, scene_folder: Path, s3_url: str) -> None:
    """With the policy of docs/static.md, without credentials, as `Readers` there says."""
    publish_to_bucket(scene_folder, s3_url, player=None)
    address = f"{s3_server.address}/bucket/{s3_url.rpartition('/')[2]}"

    def get(name: str) -> bytes:
        with urlopen(f"{address}/{name}", timeout=30) as answer:
            return bytes(answer.read())

    with pytest.raises(HTTPError, match="403"):
        get("index.hgs")
    let_all_read(s3_server, s3_url)
    manifest = PagedManifest(read_index(get("index.hgs"))).manifest
    for entry in manifest.chunks:
        assert get(f"chunks/{entry.id}") == chunk_bytes(scene_folder / "scene", entry)


def let_all_read(s3_server: S3Server, s3_url: str) -> None:
    """Give the bucket the policy and the CORS rules of docs/static.md, its prefix being that of `s3_url`."""
    import boto3

    policy, rules = re.findall(r"^```json\n(.+?)^```", (REPOSITORY / "docs" / "static.md").read_text(), re.M | re.S)
    prefix = s3_url.removeprefix("s3://bucket/")
    client = boto3.client(
        "s3", endpoint_url=s3_server.address, region_name="us-east-1", aws_access_key_id="a", aws_secret_access_key="b"
    )
    client.put_bucket_policy(Bucket="bucket", Policy=policy.replace("BUCKET", "bucket").replace("scene/", f"{prefix}/"))
    client.put_bucket_cors(Bucket="bucket", CORSConfiguration=json.loads(rules))
    client.close()


@pytest.mark.parametrize(
    "wrong",
    [
        "s3://",
        "s3:/bucket/scene",
        "s3://bucket//scene",
        "s3://bucket/a?b",
        "s3://bucket/../a",
        "s3://b ucket/a",
        "gs://b",
    ],
)
def test_a_malformed_address_is_refused(scene_folder: Path, wrong: str) -> None:
    with pytest.raises(InputError, match=rf"^{re.escape(wrong)}: is not the URL of a bucket; give s3://BUCKET/"):
        publish_to_bucket(scene_folder, wrong, player=None)


def test_a_bucket_that_does_not_exist_is_told(scene_folder: Path, s3_url: str) -> None:
    with pytest.raises(InputError, match=r"^s3://nobodys/scene: there is no such bucket; create it, or"):
        publish_to_bucket(scene_folder, "s3://nobodys/scene", player=None)


@pytest.fixture
def refusing(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[int, str], None]]:
    """Return a function that sets a store's answer to every request: a code of S3, or a body."""
    answer = (500, b"")

    class Refusing(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(answer[0])
            self.send_header("Content-Length", str(len(answer[1])))
            self.end_headers()
            self.wfile.write(answer[1])

        def log_message(self, *arguments: Any) -> None:
            pass

    def become(status: int, code: str) -> None:
        nonlocal answer
        answer = (status, f"<Error><Code>{code}</Code></Error>".encode() if code.isalnum() else code.encode())

    with ThreadingHTTPServer(("127.0.0.1", 0), Refusing) as server:
        settings = S3Server().settings | {"AWS_ENDPOINT": f"http://127.0.0.1:{server.server_port}"}
        for name, value in settings.items():
            monkeypatch.setenv(name, value)
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        yield become
        server.shutdown()
        thread.join()


@pytest.mark.parametrize(
    ("status", "code", "problem"),
    [
        (
            403,
            "SignatureDoesNotMatch",
            r"the store refuses access \(403: SignatureDoesNotMatch\); set AWS_ACCESS_KEY_ID",
        ),
        (401, "", r"the store refuses access \(401\); set AWS_ACCESS_KEY_ID"),
        (301, "", r"the bucket is in another region; set AWS_REGION"),
        (400, "InvalidRequest", r"the store failed \(400: InvalidRequest\); repeat the command"),
        (400, "no S3 here", r"the store failed \(400\); repeat the command"),
    ],
)
def test_a_refusal_is_one_line(
    refusing: Callable[[int, str], None], scene_folder: Path, status: int, code: str, problem: str
) -> None:
    refusing(status, code)
    with pytest.raises(InputError, match=f"^s3://bucket/scene: {problem}") as told:
        publish_to_bucket(scene_folder, "s3://bucket/scene", player=None)
    assert "\n" not in str(told.value)


def test_a_store_that_does_not_answer_is_named(scene_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nobody = S3Server()
    for name, value in nobody.settings.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("server.publishing.web_bucket.open_object_store", partial(open_object_store, once=True))
    problem = f"the store at {nobody.address} failed (HTTP error: error sending request); repeat the command, which"
    with pytest.raises(InputError, match=f"^s3://bucket/scene: {re.escape(problem)}"):
        publish_to_bucket(scene_folder, "s3://bucket/scene", player=None)


def test_a_file_of_the_run_that_is_gone_is_named(scene_folder: Path, s3_url: str) -> None:
    (scene_folder / "scene" / "thumbnail.jpg").unlink()
    with pytest.raises(InputError, match=r"cannot be written \(.*No such file or directory: '.*thumbnail\.jpg'\)"):
        publish_to_bucket(scene_folder, s3_url, player=None)


def test_a_store_without_tls_needs_leave(scene_folder: Path, s3_url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AWS_ALLOW_HTTP")
    with pytest.raises(InputError, match=r"the store's address is not https; .*AWS_ALLOW_HTTP=true"):
        publish_to_bucket(scene_folder, s3_url, player=None)
