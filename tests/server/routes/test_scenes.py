from __future__ import annotations

import gzip
import hashlib
import json
from typing import Any

import pytest

from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.paged_manifest import PagedManifest, read_index
from tests.growing import MOVING, STATIC, growing_manifest


@pytest.fixture(autouse=True)
def studio(server: Any, manifest: bytes) -> None:
    server.artifacts.manifests["studio"] = manifest
    server.artifacts.thumbnails["studio"] = b"jpeg"


def test_scene_is_described(server: Any, chunks: list[bytes], manifest: bytes) -> None:
    assert server.get("/v1/scenes/studio").json() == {
        "id": "studio",
        "title": "Studio",
        "created": 1000.0,
        "start": 0.0,
        "end": 3.0,
        "bytes_total": sum(map(len, chunks)) + len(manifest),
        "splats_static": 2,
        "splats_dynamic": 60,
        "live": False,
    }


def test_scene_of_a_job_has_the_title_of_the_job(server: Any, manifest: bytes) -> None:
    job = server.request("POST", "/v1/jobs", json={"capture": "studio", "title": "My studio"}).json()
    server.artifacts.manifests[job["id"]] = manifest
    assert server.get(f"/v1/scenes/{job['id']}").json()["title"] == "My studio"


def test_scenes_are_listed(server: Any) -> None:
    assert server.get("/v1/scenes").json() == {"scenes": [server.get("/v1/scenes/studio").json()]}


def test_scene_that_cannot_be_read_is_left_out_of_the_list(server: Any) -> None:
    server.artifacts.manifests["broken"] = b"{}"
    assert [scene["id"] for scene in server.get("/v1/scenes").json()["scenes"]] == ["studio"]
    assert server.get("/v1/scenes/broken").status_code == 500


@pytest.mark.parametrize(
    ("name", "body", "media_type"), [("manifest", None, "application/json"), ("thumbnail", b"jpeg", "image/jpeg")]
)
def test_files_of_a_scene_are_revalidated(
    server: Any, manifest: bytes, name: str, body: bytes | None, media_type: str
) -> None:
    response = server.get(f"/v1/scenes/studio/{name}", Accept_Encoding="")
    assert (response.status_code, response.content) == (200, body or manifest)
    assert response.headers["content-type"] == media_type
    assert response.headers["cache-control"] == "no-cache"
    etag = response.headers["etag"]
    assert etag == f'"{hashlib.sha256(response.content).hexdigest()}"'
    assert server.get(f"/v1/scenes/studio/{name}", Accept_Encoding="", If_None_Match=etag).status_code == 304


def test_index_and_chunks_lie_as_in_a_folder(server: Any, manifest: bytes, chunks: list[bytes]) -> None:
    for chunk in chunks:
        server.artifacts.add_chunk(chunk)
    server.artifacts.add_chunk(b"of another scene")
    index = server.get("/v1/scenes/studio/index.hgs")
    assert json.loads(gzip.decompress(index.content)) == json.loads(manifest)
    assert index.headers["cache-control"] == "no-cache"
    tag = index.headers["etag"]
    assert server.get("/v1/scenes/studio/index.hgs", If_None_Match=tag).status_code == 304
    names = [hashlib.sha256(data).hexdigest() for data in (*chunks, b"of another scene")]
    found = [server.get(f"/v1/scenes/studio/chunks/{name}") for name in names]
    assert [answer.content for answer in found[:-1]] == chunks
    assert {answer.headers["cache-control"] for answer in found[:-1]} == {"public, max-age=31536000, immutable"}
    assert (found[-1].status_code, found[-1].json()["code"]) == (404, "chunk-not-found")
    assert server.get("/v1/scenes/studio/chunks/ab").status_code == 404


def test_pages_of_a_manifest_lie_among_the_chunks(server: Any) -> None:
    manifest = json.dumps(first_segments(growing_manifest(STATIC, MOVING), 2).to_json()).encode()
    server.artifacts.manifests["growing"] = manifest
    index = read_index(server.get("/v1/scenes/growing/index.hgs").content)
    paged = PagedManifest(index)
    (row,) = paged.pages
    answer = server.get(f"/v1/scenes/growing/chunks/{row.id}")
    paged.add(row.id, answer.content)
    assert paged.manifest.to_json() == json.loads(manifest)
    assert answer.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert server.get(f"/v1/scenes/growing/chunks/{row.id}", Range="bytes=0-3").content == answer.content[:4]
    assert server.get(f"/v1/chunks/{row.id}").status_code == 404


def test_manifest_is_compressed_for_those_who_ask(server: Any, manifest: bytes) -> None:
    response = server.get("/v1/scenes/studio/manifest", Accept_Encoding="gzip")
    assert (response.headers["content-encoding"], response.content) == ("gzip", manifest)  # decoded by the client


def test_lists_are_compressed_and_revalidated(server: Any, manifest: bytes) -> None:
    for k in range(10):
        server.artifacts.manifests[f"studio-{k}"] = manifest
    for path in ("/v1/scenes", "/v1/jobs"):
        for _ in range(3):
            server.request("POST", "/v1/jobs", json={"capture": "studio"})
        response = server.get(path, Accept_Encoding="gzip")
        assert response.headers["content-encoding"] == "gzip"
        etag = response.headers["etag"]
        assert server.get(path, Accept_Encoding="gzip", If_None_Match=etag).status_code == 304


@pytest.mark.parametrize(
    ("path", "code"),
    [
        ("/v1/scenes/no", "scene-not-found"),
        ("/v1/scenes/no/manifest", "scene-not-found"),
        ("/v1/scenes/no/thumbnail", "thumbnail-not-found"),
    ],
)
def test_unknown_scenes_are_404(server: Any, path: str, code: str) -> None:
    response = server.get(path)
    assert (response.status_code, response.json()["code"]) == (404, code)
    assert response.headers["content-type"] == "application/problem+json"


def test_pages_of_other_hosts_get_no_permission_by_default(server: Any) -> None:
    assert (
        "access-control-allow-origin"
        not in server.get("/v1/scenes/studio/manifest", Origin="https://a.example").headers
    )


def test_scene_is_renamed_in_the_list_and_the_manifest_stays(server: Any, manifest: bytes) -> None:
    server.get("/v1/scenes")
    answer = server.request("PATCH", "/v1/scenes/studio", json={"title": "  Zoë's studio "})
    assert (answer.status_code, answer.json()["title"]) == (200, "Zoë's studio")
    assert answer.json() == server.get("/v1/scenes/studio").json() == server.get("/v1/scenes").json()["scenes"][0]
    assert server.get("/v1/scenes/studio/manifest").content == manifest


def test_new_title_counts_more_than_that_of_the_job(server: Any, manifest: bytes) -> None:
    job = server.request("POST", "/v1/jobs", json={"capture": "studio", "title": "My studio"}).json()
    server.artifacts.manifests[job["id"]] = manifest
    server.request("PATCH", f"/v1/scenes/{job['id']}", json={"title": "Ours"})
    assert server.get(f"/v1/scenes/{job['id']}").json()["title"] == "Ours"


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({}, "title"),
        ({"title": ""}, "title"),
        ({"title": "   "}, "title"),
        ({"title": "x" * 201}, "title"),
        ({"title": "two\nlines"}, "title"),
        ({"title": 3}, "title"),
        ({"title": None}, "title"),
        ({"title": "fine", "start": 0}, "start"),
    ],
)
def test_bad_titles_are_422_and_change_nothing(server: Any, body: dict[str, Any], field: str) -> None:
    answer = server.request("PATCH", "/v1/scenes/studio", json=body)
    assert (answer.status_code, answer.json()["code"], answer.json()["field"]) == (422, "body-invalid", field)
    assert server.get("/v1/scenes/studio").json()["title"] == "Studio"


def test_deleted_scene_is_gone_and_its_chunks_stay(server: Any, chunks: list[bytes]) -> None:
    chunk = server.artifacts.add_chunk(chunks[0])
    assert server.request("DELETE", "/v1/scenes/studio").status_code == 204
    for path in ("", "/manifest", "/thumbnail"):
        assert server.get(f"/v1/scenes/studio{path}").status_code == 404
    assert server.get("/v1/scenes").json() == {"scenes": []}
    assert server.get(f"/v1/chunks/{chunk}").content == chunks[0]


@pytest.mark.parametrize("scene_id", ["no", "..", "A"])
@pytest.mark.parametrize(("method", "arguments"), [("PATCH", {"json": {"title": "New"}}), ("DELETE", {})])
def test_scenes_that_are_not_there_cannot_be_changed(
    server: Any, scene_id: str, method: str, arguments: dict[str, Any]
) -> None:
    answer = server.request(method, f"/v1/scenes/{scene_id}", **arguments)
    assert answer.status_code in (404, 405)
    assert server.artifacts.titles == {}


@pytest.mark.parametrize(("method", "arguments"), [("PATCH", {"json": {"title": "New"}}), ("DELETE", {})])
def test_pages_of_other_origins_may_not_change_scenes(server: Any, method: str, arguments: dict[str, Any]) -> None:
    before = server.get("/v1/scenes").json()
    headers = {"Origin": "https://elsewhere.example"}
    answer = server.request(method, "/v1/scenes/studio", headers=headers, **arguments)
    assert (answer.status_code, answer.json()["code"]) == (403, "origin-not-allowed")
    assert server.get("/v1/scenes").json() == before
