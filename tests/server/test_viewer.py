from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def viewer(tmp_path: Path, server: Any) -> Path:
    folder = tmp_path / "viewer"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<title>index</title>")
    (folder / "assets" / "main-1a2b.js").write_text("1;")
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


def test_page_addresses_fall_back_to_the_index(server: Any, viewer: Path) -> None:
    assert "index" in server.get("/scene/studio").text


def test_missing_files_are_404(server: Any, viewer: Path) -> None:
    assert server.get("/assets/other.js").status_code == 404


@pytest.mark.parametrize("path", ["/../secret.txt", "/%2e%2e/secret.txt", "/assets/..%2f..%2fsecret.txt", "/a%00.js"])
def test_nothing_outside_the_folder_is_served(server: Any, viewer: Path, path: str) -> None:
    response = server.get(path)
    assert response.status_code == 404
    assert "secret" not in response.text.replace("secret.txt", "")


def test_page_says_how_to_build_the_viewer(server: Any) -> None:
    response = server.get("/")
    assert response.status_code == 503
    assert "npm run build" in response.text
