from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import pytest

from hgs_core.base.errors import InputError
from server.app import create_app
from server.http.site_root import SiteRoot, configured_root
from tests.server.conftest import Server


@pytest.mark.parametrize(
    ("given", "root"),
    [
        ("", ""),
        ("/", ""),
        ("/hgs", "/hgs"),
        ("hgs/", "/hgs"),
        ("/a/b/c/", "/a/b/c"),
        ("/my%20scenes", "/my scenes"),
        ("/my scenes/hgs", "/my scenes/hgs"),
        ("/view", "/view"),
    ],
)
def test_a_root_is_read_as_people_write_it(given: str, root: str) -> None:
    assert configured_root(given, {}) == root
    assert configured_root("", {"HGS_ROOT_PATH": given}) == root


@pytest.mark.parametrize("given", ["/a/../b", "//evil.example", "/a?b", "/a#b", "/a\nb", "/%2e%2e", "/" + "a" * 300])
def test_what_is_no_path_is_refused_with_a_cure(given: str) -> None:
    with pytest.raises(InputError, match=r"--root-path or HGS_ROOT_PATH: .*such as /hgs"):
        configured_root(given, {})


def below(server: Server, root: str, **settings: Any) -> Server:
    """The same server behind a proxy that leaves its path."""
    app = create_app(server.home, job_client=server.jobs, artifacts=server.artifacts, root=root, **settings)
    return replace(server, app=app)


def test_paths_are_those_below_the_root_where_the_proxy_has_left_it(server: Server) -> None:
    kept = below(server, "/my scenes")
    assert kept.get("/my%20scenes/v1/health").status_code == 200
    assert kept.get("/v1/health").status_code == 200  # a request of the machine itself
    assert kept.get("/my%20scenesv1/health").status_code == 404


@pytest.mark.parametrize(("query", "location"), [("", "my%20scenes/"), ("?t=1", "my%20scenes/?t=1")])
def test_the_root_without_its_slash_leads_to_it(server: Server, query: str, location: str) -> None:
    answer = below(server, "/a/my scenes").get(f"/a/my%20scenes{query}")
    assert (answer.status_code, answer.headers["location"]) == (308, location)


def test_a_problem_names_the_path_that_was_asked_for(server: Server) -> None:
    asked = "/my%20scenes/v1/scenes/none"
    assert below(server, "/my scenes").get(asked).json()["instance"] == asked
    told = server.get("/v1/scenes/none", **{"X-Forwarded-Prefix": "/my%20scenes/"})
    assert told.json()["instance"] == asked


def test_two_proxies_are_both_in_front(server: Server) -> None:
    kept = below(server, "/hgs")
    answer = kept.get("/hgs/v1/scenes/none", **{"X-Forwarded-Prefix": "/outer"})
    assert answer.json()["instance"] == "/outer/hgs/v1/scenes/none"
    answer = kept.get("/hgs/v1/scenes/none", **{"X-Forwarded-Prefix": "/hgs"})  # the proxy's own prefix
    assert answer.json()["instance"] == "/hgs/v1/scenes/none"


@pytest.mark.parametrize("told", ["//evil.example", "/a;b\t", "/../..", "/" + "a" * 300])
def test_a_prefix_that_is_none_is_passed_over(server: Server, told: str) -> None:
    instance = server.get("/v1/scenes/none", **{"X-Forwarded-Prefix": told}).json()["instance"]
    assert instance in ("/v1/scenes/none", "/a%3Bb/v1/scenes/none")


def test_places_of_what_was_made_are_relative_to_the_request(server: Server) -> None:
    body = {"name": "studio", "files": 1, "bytes": 1}
    made = server.request("POST", "/v1/uploads", json=body)
    assert (
        urljoin("http://h/hgs/v1/uploads", made.headers["location"]) == f"http://h/hgs/v1/uploads/{made.json()['id']}"
    )
    server.app.state.service.uploads.close()


def test_the_description_of_the_api_is_about_where_it_lies(server: Server) -> None:
    assert server.get("/openapi.json").json()["servers"] == [{"url": "."}]


PAGE = '<link href="./icon.svg"><script src="./assets/index.js"></script><a href="https://x/./y">'


@pytest.mark.parametrize(
    ("path", "up"),
    [
        ("/", "./"),
        ("/index.html", "./"),
        ("/new", "./"),
        ("/new/", "../"),
        ("/view/studio", "../"),
        ("/view/studio/", "../../"),
        ("/job/a", "../"),
        ("/no/such/page", "../../"),
        ("/a%2Fb", "./"),
    ],
)
def test_addresses_in_a_page_lead_from_it_to_the_root(server: Server, tmp_path: Path, path: str, up: str) -> None:
    (tmp_path / "viewer").mkdir(exist_ok=True)
    for name in ("index", "new", "job", "view"):
        (tmp_path / "viewer" / f"{name}.html").write_text(PAGE)
    kept = below(server, "/hgs", viewer=tmp_path / "viewer")
    for found in (server.get(path, Accept="text/html"), kept.get(f"/hgs{path}", Accept="text/html")):
        assert found.text == PAGE.replace('"./', f'"{up}')


def test_what_is_no_request_passes() -> None:
    seen: list[str] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        seen.append(scope["type"])

    asyncio.run(SiteRoot(app, "/hgs")({"type": "lifespan"}, None, None))  # type: ignore[arg-type]
    assert seen == ["lifespan"]
