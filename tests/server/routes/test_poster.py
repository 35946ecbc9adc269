"""The picture of a scene in its page, for permitted visitors."""

from __future__ import annotations

import base64
import hashlib
import re
from pathlib import Path
from urllib.parse import urljoin

import pytest

from jobs.records.keys import Scope
from server.access import visitors as access_module
from server.access.signed_tokens import SignedToken, sign_token
from server.access.visitors import Access, Asking
from server.app import create_app
from server.captures.capture_folders import CaptureFolders
from server.routes.poster import Poster
from tests.server.access_keys import FakeKeys
from tests.server.conftest import FakeArtifacts, FakeJobs, Server

PAGE = "<html><head><title>HGS</title><script src=a.js></script></head>\n<body>\n</body></html>"
NOW = 1000.0


@pytest.fixture
def keys() -> FakeKeys:
    return FakeKeys()


@pytest.fixture(params=[Asking.NEVER, Asking.ALWAYS])
def asking(request: pytest.FixtureRequest) -> Asking:
    asking: Asking = request.param
    return asking


@pytest.fixture
def pages(server: Server, keys: FakeKeys, asking: Asking, manifest: bytes, monkeypatch: pytest.MonkeyPatch) -> Server:
    """The scene studio with a picture, and the scene plain without one."""
    monkeypatch.setattr(access_module, "FRESH_SECONDS", 0.0)
    folder = server.home.folder.parent / "viewer"
    folder.mkdir()
    (folder / "view.html").write_text(PAGE)
    (folder / "index.html").write_text("<title>HGS</title>")
    artifacts = FakeArtifacts(thumbnails={"studio": b"jpeg"})
    artifacts.manifests = {"studio": manifest, "plain": manifest.replace(b'"thumbnail": true', b'"thumbnail": false')}
    access = Access(keys, asking, lambda: NOW)
    app = create_app(
        server.home,
        captures=CaptureFolders(()),
        job_client=FakeJobs(),
        artifacts=artifacts,
        access=access,
        viewer=folder,
    )
    return Server(app, FakeJobs(), artifacts, server.captures, server.home)


def addresses(page: str) -> set[str]:
    """Every address of a picture that the page names."""
    return set(re.findall(r"""(?<=["(])[^"(]*thumbnail[^")]*""", page))


@pytest.mark.parametrize("asking", [Asking.NEVER], indirect=True)
@pytest.mark.parametrize("path", ["/view/studio", "/view/studio/", "/hgs/view/studio", "/hgs/view/studio/"])
def test_the_poster_is_asked_for_before_the_scripts_and_is_the_thumbnail(pages: Server, path: str) -> None:
    page = pages.get(path.removeprefix("/hgs")).text
    assert page.index('rel="preload" as="image"') < page.index("<script")
    [address] = addresses(page)
    prefix = "/hgs" if path.startswith("/hgs") else ""
    assert urljoin(f"https://example.org{path}", address) == f"https://example.org{prefix}/v1/scenes/studio/thumbnail"
    assert pages.get(urljoin(path.removeprefix("/hgs"), address)).content == b"jpeg"


@pytest.mark.parametrize("asking", [Asking.NEVER], indirect=True)
def test_the_policy_allows_the_style_of_the_poster_and_no_other(pages: Server) -> None:
    answer = pages.get("/view/studio")
    [style] = re.findall(r"<style>(.*?)</style>", answer.text, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    policy = answer.headers["content-security-policy"]
    assert f"style-src 'self' 'sha256-{digest}';" in policy
    assert "unsafe-inline" not in policy


@pytest.mark.parametrize("asking", [Asking.NEVER], indirect=True)
@pytest.mark.parametrize("scene", ["plain", "nowhere", "A.b-C_1"])
def test_a_scene_without_a_picture_has_the_page_as_it_was_built(pages: Server, scene: str) -> None:
    answer = pages.get(f"/view/{scene}")
    assert (answer.status_code, answer.text) == (200, PAGE)


@pytest.mark.parametrize("asking", [Asking.NEVER], indirect=True)
def test_a_page_that_the_client_has_is_not_sent_again(pages: Server) -> None:
    etag = pages.get("/view/studio").headers["etag"]
    assert pages.get("/view/studio", If_None_Match=etag).status_code == 304


@pytest.mark.parametrize("asking", [Asking.ALWAYS], indirect=True)
def test_without_a_key_no_page_tells_whether_there_is_such_a_scene(pages: Server) -> None:
    assert pages.get("/view/studio").text == pages.get("/view/nowhere").text == PAGE


@pytest.mark.parametrize("asking", [Asking.ALWAYS], indirect=True)
def test_with_a_key_the_poster_is_there_and_no_cache_shows_it_to_others(pages: Server, keys: FakeKeys) -> None:
    answer = pages.get("/view/studio", Authorization=f"Bearer {keys.add('anna', Scope.VIEW)}")
    assert addresses(answer.text) == {"../v1/scenes/studio/thumbnail"}
    assert {"Authorization", "Cookie"} <= {name.strip() for name in answer.headers["Vary"].split(",")}


@pytest.mark.parametrize("asking", [Asking.ALWAYS], indirect=True)
def test_a_link_shows_the_poster_of_its_own_scene_alone(pages: Server) -> None:
    token = sign_token(SignedToken("link", int(NOW) + 60, "", "studio"), b"s" * 32)
    [address] = addresses(pages.get(f"/view/studio?link={token}").text)
    assert pages.get(urljoin("/view/studio", address)).content == b"jpeg"
    other = sign_token(SignedToken("link", int(NOW) + 60, "", "plain"), b"s" * 32)
    assert pages.get(f"/view/studio?link={other}").text == PAGE
    assert pages.get('/view/studio?link=")}<script>').text == PAGE


def test_an_address_cannot_leave_the_style() -> None:
    page, _ = Poster("../v1/scenes/a/thumbnail?link=%22%29", 1.5).painted_on(PAGE)
    assert page.count("<style>") == page.count("</style>") == 1
    assert 'url("../v1/scenes/a/thumbnail?link=%22%29")' in page


def test_a_store_that_fails_leaves_a_page(server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "viewer").mkdir()
    (tmp_path / "viewer" / "view.html").write_text(PAGE)

    def fail(scene_id: str) -> None:
        raise OSError("the store does not answer")

    monkeypatch.setattr(server.artifacts, "scene_entry", fail)
    assert server.get("/view/studio").text == PAGE
