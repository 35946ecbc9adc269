from __future__ import annotations

import pytest

from jobs.records.keys import Scope
from server.access import visitors as access_module
from server.access.visitors import Access, Asking
from server.app import create_app
from tests.server.access_keys import FakeKeys
from tests.server.conftest import FakeArtifacts, FakeJobs, Server


@pytest.fixture
def guarded(server: Server, manifest: bytes, monkeypatch: pytest.MonkeyPatch) -> tuple[Server, FakeKeys]:
    monkeypatch.setattr(access_module, "FRESH_SECONDS", 0.0)
    keys = FakeKeys()
    artifacts = FakeArtifacts(manifests={"studio": manifest})
    access = Access(keys, Asking.ALWAYS, lambda: 1000.5)
    app = create_app(server.home, job_client=FakeJobs(), artifacts=artifacts, access=access)
    return Server(app, server.jobs, artifacts, server.captures, server.home), keys


def test_a_link_is_made_by_who_may_publish_and_opens_the_scene(guarded: tuple[Server, FakeKeys]) -> None:
    server, keys = guarded
    bearer = {"Authorization": f"Bearer {keys.add('anna', Scope.PUBLISH)}"}
    wish = {"scene": "studio", "seconds": 60}
    made = server.request("POST", "/v1/links", json=wish, headers=bearer)
    assert (made.status_code, made.json()["expires"]) == (201, 1060)
    assert made.json()["page"] == f"/view/studio?link={made.json()['link']}"
    assert server.get(f"/v1/scenes/studio/manifest?link={made.json()['link']}").status_code == 200
    below = server.request("POST", "/v1/links", json=wish, headers=bearer | {"X-Forwarded-Prefix": "/hgs"}).json()
    assert below["page"] == f"/hgs/view/studio?link={below['link']}"
    viewer = {"Authorization": f"Bearer {keys.add('otto', Scope.VIEW)}"}
    assert server.request("POST", "/v1/links", json=wish, headers=viewer).status_code == 403


@pytest.mark.parametrize(
    ("wish", "status"),
    [
        ({"scene": "nowhere", "seconds": 60}, 404),
        ({"scene": "studio", "seconds": 0}, 422),
        ({"scene": "studio", "seconds": 10**9}, 422),
        ({"scene": "studio"}, 422),
    ],
)
def test_a_bad_wish_is_refused(guarded: tuple[Server, FakeKeys], wish: dict[str, object], status: int) -> None:
    server, keys = guarded
    bearer = {"Authorization": f"Bearer {keys.add('anna', Scope.ADMIN)}"}
    assert server.request("POST", "/v1/links", json=wish, headers=bearer).status_code == status
