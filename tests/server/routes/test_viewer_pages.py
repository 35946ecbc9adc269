from __future__ import annotations

import gzip
import hashlib
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def viewer(tmp_path: Path, server: Any) -> Path:
    folder = tmp_path / "viewer"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<title>index</title>")
    for page in ("view", "job", "new"):
        (folder / f"{page}.html").write_text(f"<title>{page}</title>")
    (folder / ".built-1a2b").write_text("")
    script = folder / "assets" / "main-1a2b.js"
    script.write_text("1;" * 1000)
    Path(f"{script}.br").write_bytes(b"the build makes this")
    Path(f"{script}.gz").write_bytes(gzip.compress(script.read_bytes()))
    (folder / "assets" / "zstd-1a2b.wasm").write_bytes(b"\0asm")
    (tmp_path / "secret.txt").write_text("secret")
    return folder


@pytest.mark.parametrize(
    ("path", "media_type"),
    [
        ("/", "text/html; charset=utf-8"),
        ("/index.html", "text/html; charset=utf-8"),
        ("/assets/main-1a2b.js", "text/javascript; charset=utf-8"),
        ("/assets/zstd-1a2b.wasm", "application/wasm"),
    ],
)
def test_files_have_the_types_that_browsers_ask_for(server: Any, viewer: Path, path: str, media_type: str) -> None:
    response = server.get(path)
    assert (response.status_code, response.headers["content-type"]) == (200, media_type)


def test_files_named_by_content_are_immutable_and_pages_are_not(server: Any, viewer: Path) -> None:
    assert "immutable" in server.get("/assets/main-1a2b.js").headers["cache-control"]
    assert server.get("/").headers["cache-control"] == "no-cache"


@pytest.mark.parametrize("path", ["/view/studio", "/view/studio/", "/view/A.b-C_1"])
def test_every_scene_has_a_page(server: Any, viewer: Path, path: str) -> None:
    assert "view" in server.get(path).text


@pytest.mark.parametrize(
    ("path", "page"),
    [("/", "index"), ("/new", "new"), ("/new/", "new"), ("/job/studio-1f9c03ab", "job"), ("/job/a_b/", "job")],
)
def test_pages_of_the_console_are_at_their_addresses_and_in_no_frame(
    server: Any, viewer: Path, path: str, page: str
) -> None:
    answer = server.get(path)
    assert (answer.status_code, page in answer.text) == (200, True)
    assert "frame-ancestors 'none'" in answer.headers["content-security-policy"]


@pytest.mark.parametrize(
    "path",
    [
        "/metrics/x",
        "/docs",
        "/view",
        "/view/",
        "/job",
        "/job/",
        "/job/a/b",
        "/new/a",
        "/view/a/b",
        "/view/-%00",
        "/assets/other.js",
        "/assets/%00",
        "/assets/",
        "/assets",
        "/.built-1a2b",
        "/assets/main-1a2b.js.br",
        "/index.html/",
        "/" + "a" * 300,
        "/a" * 3000,
    ],
)
def test_what_is_no_page_is_404_for_programs_and_people(server: Any, viewer: Path, path: str) -> None:
    answer = server.get(path)
    assert (answer.status_code, answer.json()["code"]) == (404, "not-found")
    page = server.get(path, Accept="text/html,application/xhtml+xml,*/*;q=0.8")
    assert (page.status_code, page.headers["content-type"]) == (404, "text/html; charset=utf-8")
    assert "index" in page.text  # it says that nothing is at the address
    assert answer.headers["vary"] == "Accept"
    assert {"Accept", "Accept-Encoding"} <= {name.strip() for name in page.headers["vary"].split(",")}


@pytest.mark.parametrize(
    ("accepted", "coding"),
    [("gzip, deflate, br, zstd", "br"), ("gzip", "gzip"), ("br;q=0, gzip", "gzip"), ("identity", None), ("zstd", None)],
)
def test_scripts_are_sent_as_the_build_has_compressed_them(
    server: Any, viewer: Path, accepted: str, coding: str | None
) -> None:
    script = viewer / "assets" / "main-1a2b.js"
    suffix = {"br": ".br", "gzip": ".gz", None: ""}[coding]
    sent = script.with_name(script.name + suffix).read_bytes()
    for method in ("GET", "HEAD"):
        response = server.request(method, "/assets/main-1a2b.js", headers={"Accept-Encoding": accepted})
        assert response.headers.get("content-encoding") == coding
        assert response.headers["content-length"] == str(len(sent))
        assert response.headers["content-type"] == "text/javascript; charset=utf-8"
        assert response.headers["vary"] == "Accept-Encoding"
        assert "immutable" in response.headers["cache-control"]
        assert response.headers["etag"] == f'"{hashlib.sha256(sent).hexdigest()}"'
    same = server.get("/assets/main-1a2b.js", Accept_Encoding=accepted, If_None_Match=response.headers["etag"])
    assert (same.status_code, same.content, same.headers["vary"]) == (304, b"", "Accept-Encoding")


def test_only_pages_of_scenes_may_be_framed(server: Any, viewer: Path) -> None:
    assert "frame-ancestors 'none'" in server.get("/").headers["content-security-policy"]
    assert "frame-ancestors 'none'" in server.get("/v1/jobs").headers["content-security-policy"]
    assert "frame-ancestors" not in server.get("/view/studio").headers["content-security-policy"]


@pytest.mark.parametrize("path", ["/../secret.txt", "/%2e%2e/secret.txt", "/assets/..%2f..%2fsecret.txt", "/a%00.js"])
def test_nothing_outside_the_folder_is_served(server: Any, viewer: Path, path: str) -> None:
    response = server.get(path)
    assert response.status_code == 404
    assert "secret" not in response.text.replace("secret.txt", "")


def test_page_says_how_to_build_the_viewer(server: Any) -> None:
    response = server.get("/")
    assert response.status_code == 503
    assert "npm run build" in response.text
