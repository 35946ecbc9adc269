"""Published scenes, read by software of others: Amazon's own client of S3, and a cache of nginx before a folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import boto3
import httpx
import pytest

from hgs_core.codec.format.scene_folder import load_manifest
from server.publishing.web_bucket import publish_to_bucket
from server.publishing.web_folder import publish_to_folder
from tests.jobs.modules.s3_server import S3Server
from tests.nginx import free_ports, running_nginx

CHUNKS = "public, max-age=31536000, immutable"

ORIGIN = """
server {{
    listen 127.0.0.1:{origin};
    root {web};
    location / {{ add_header Cache-Control no-cache; }}
    location /chunks/ {{ add_header Cache-Control "public, max-age=31536000, immutable"; }}
}}
"""
CACHE = """
proxy_cache_path {cached} keys_zone=scenes:1m;
server {{
    listen 127.0.0.1:{cache};
    location / {{
        proxy_pass http://127.0.0.1:{origin};
        proxy_cache scenes;
        proxy_cache_revalidate on;
        add_header X-Cache $upstream_cache_status;
    }}
}}
"""


def test_boto3_reads_a_published_scene(s3_server: S3Server, scene_folder: Path, s3_url: str) -> None:
    publish_to_bucket(scene_folder, s3_url, player=None)
    keys = {name.lower(): s3_server.settings[name] for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY")}
    client = boto3.client("s3", endpoint_url=s3_server.settings["AWS_ENDPOINT"], region_name="us-east-1", **keys)
    prefix = s3_url.removeprefix("s3://bucket/")
    listed = {one["Key"] for one in client.list_objects_v2(Bucket="bucket", Prefix=f"{prefix}/")["Contents"]}
    read = {key.removeprefix(f"{prefix}/"): client.get_object(Bucket="bucket", Key=key) for key in listed}
    manifest = json.loads(read["manifest.json"]["Body"].read())
    assert manifest["title"] == "Studio"
    ids = {entry.id for entry in load_manifest(scene_folder / "scene").chunks}
    assert {name for name in read if name.startswith("chunks/")} == {f"chunks/{chunk}" for chunk in ids}
    for chunk in ids:
        found = read[f"chunks/{chunk}"]
        assert hashlib.sha256(found["Body"].read()).hexdigest() == chunk
        assert (found["ContentType"], found["CacheControl"]) == ("application/octet-stream", CHUNKS)
    part = client.get_object(Bucket="bucket", Key=f"{prefix}/chunks/{min(ids)}", Range="bytes=4-7")
    assert part["Body"].read() == (scene_folder / "scene" / "chunks" / min(ids)).read_bytes()[4:8]


@pytest.fixture
def cached(scene_folder: Path, tmp_path: Path) -> Iterator[tuple[ExitStack, httpx.Client]]:
    """The published scene behind a cache: the end of its server, and a client of the cache."""
    publish_to_folder(scene_folder, tmp_path / "web", player=None)
    origin, cache = free_ports(2)
    facts = {"origin": origin, "cache": cache, "web": tmp_path / "web", "cached": tmp_path / "kept"}
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
    with ExitStack() as behind:
        behind.enter_context(running_nginx(tmp_path / "first", ORIGIN.format(**facts), [origin]))
        with (
            running_nginx(tmp_path / "second", CACHE.format(**facts), [cache]),
            httpx.Client(base_url=f"http://127.0.0.1:{cache}", trust_env=False) as client,
        ):
            yield behind, client


def test_a_cache_keeps_chunks_when_their_server_is_gone(
    cached: tuple[ExitStack, httpx.Client], scene_folder: Path
) -> None:
    behind, client = cached
    chunks = sorted((scene_folder / "scene" / "chunks").iterdir())
    for chunk in chunks:
        assert client.get(f"/chunks/{chunk.name}").headers["x-cache"] == "MISS"
    behind.close()
    for chunk in chunks:
        answer = client.get(f"/chunks/{chunk.name}")
        assert (answer.content, answer.headers["x-cache"]) == (chunk.read_bytes(), "HIT")
        part = client.get(f"/chunks/{chunk.name}", headers={"Range": "bytes=4-7"})
        assert (part.status_code, part.content) == (206, chunk.read_bytes()[4:8])
    assert client.get("/manifest.json").status_code == 502


def test_a_cache_never_answers_with_the_manifest_of_a_scene_that_was_replaced(
    cached: tuple[ExitStack, httpx.Client], other_scene: Path, tmp_path: Path
) -> None:
    _, client = cached
    first = client.get("/manifest.json")
    assert first.json()["title"] == "Studio"
    publish_to_folder(other_scene, tmp_path / "web", player=None, replace=True)
    after = client.get("/manifest.json", headers={"If-None-Match": first.headers["etag"]})
    assert (after.status_code, after.json()["title"]) == (200, "<Other> & more")
    assert client.get("/index.hgs").content == (tmp_path / "web" / "index.hgs").read_bytes()
