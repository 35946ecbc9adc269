"""The artifact store on an object store: moto's S3 server, where it is installed."""

from __future__ import annotations

import shutil
import socket
import subprocess
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from jobs.artifacts import ArtifactStore


@pytest.fixture(scope="module")
def endpoint() -> Iterator[str]:
    """Return the address of an S3 server with a bucket named "bucket"."""
    command = shutil.which("moto_server")
    if command is None:
        pytest.skip("moto_server is not on PATH: pip install 'moto[server]' to run these tests")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    quiet = subprocess.DEVNULL
    process = subprocess.Popen([command, "-H", "127.0.0.1", "-p", str(port)], stdout=quiet, stderr=quiet)
    try:
        address = f"http://127.0.0.1:{port}"
        bucket = urllib.request.Request(f"{address}/bucket", method="PUT")
        deadline = time.monotonic() + 60
        while True:
            try:
                urllib.request.urlopen(bucket).close()
                break
            except OSError:
                assert time.monotonic() < deadline, "the S3 server does not answer"
                time.sleep(0.05)
        yield address
    finally:
        process.kill()
        process.wait()


@pytest.fixture
def store(endpoint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ArtifactStore:
    settings = {
        "AWS_ENDPOINT": endpoint,
        "AWS_ALLOW_HTTP": "true",
        "AWS_REGION": "us-east-1",
        "AWS_ACCESS_KEY_ID": "test",
        "AWS_SECRET_ACCESS_KEY": "test",
    }
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    return ArtifactStore(f"s3://bucket/{tmp_path.name}")


def test_a_published_scene_can_be_read_and_removed(
    store: ArtifactStore, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    (chunk,) = write_scene(tmp_path / "scene", (b"a chunk",))
    manifest = (tmp_path / "scene" / "manifest.json").read_bytes()
    store.put_scene(tmp_path / "scene", "a")
    assert [entry.id for entry in store.list_scenes()] == ["a"]
    assert (store.manifest("a"), store.thumbnail("a"), store.chunk(chunk)) == (manifest, b"a picture", b"a chunk")
    store.remove_scene("a")
    store.remove_scene("a")
    assert store.list_scenes() == []
    assert store.chunk(chunk) == b"a chunk"


def test_a_scene_looked_up_has_the_version_of_the_listed_one(
    store: ArtifactStore, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    write_scene(tmp_path / "scene")
    store.put_scene(tmp_path / "scene", "a")
    entry = store.scene_entry("a")
    assert entry is not None
    assert [(entry.id, entry.version)] == [(one.id, one.version) for one in store.list_scenes()]
    assert store.scene_entry("b") is None


def test_nothing_published_is_overwritten(
    store: ArtifactStore, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    write_scene(tmp_path / "first", title="First")
    write_scene(tmp_path / "second", title="Second")
    store.put_scene(tmp_path / "first", "a")
    store.put_scene(tmp_path / "second", "a")
    assert store.manifest("a") == (tmp_path / "first" / "manifest.json").read_bytes()


def test_unknown_names_are_none(store: ArtifactStore) -> None:
    assert store.manifest("nobody") is None
    assert store.thumbnail("nobody") is None
    assert store.chunk("0" * 64) is None
