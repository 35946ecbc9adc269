from __future__ import annotations

import pytest

from jobs.records.keys import Scope
from server.access import visitors as access_module
from server.access.visitors import Access, Asking
from server.app import create_app
from tests.server.access_keys import FakeKeys
from tests.server.conftest import FakeArtifacts, FakeJobs, Server


@pytest.fixture
def keys() -> FakeKeys:
    return FakeKeys()


@pytest.fixture
def guarded(server: Server, keys: FakeKeys, monkeypatch: pytest.MonkeyPatch) -> Server:
    monkeypatch.setattr(access_module, "FRESH_SECONDS", 0.0)
    access = Access(keys, Asking.ALWAYS)
    app = create_app(server.home, job_client=FakeJobs(), artifacts=FakeArtifacts(), access=access)
    return Server(app, server.jobs, server.artifacts, server.captures, server.home)


def test_the_cookie_is_for_the_path_that_a_proxy_has_put_the_server_under(guarded: Server, keys: FakeKeys) -> None:
    told = {"X-Forwarded-Prefix": "/my%20scenes/hgs"}
    text = keys.add("anna", Scope.SUBMIT)
    begun = guarded.request("POST", "/v1/session", json={"key": text}, headers=told)
    assert "; Path=/my%20scenes/hgs/;" in begun.headers["Set-Cookie"]
    ended = guarded.request("DELETE", "/v1/session", headers=told)
    assert "; Path=/my%20scenes/hgs/;" in ended.headers["Set-Cookie"]


def test_a_browser_gives_its_key_once(guarded: Server, keys: FakeKeys) -> None:
    assert guarded.get("/v1/session").json() == {"needed": True, "name": None, "scopes": []}
    text = keys.add("anna", Scope.SUBMIT)
    begun = guarded.request("POST", "/v1/session", json={"key": f" {text}\n"})
    cookie = begun.headers["Set-Cookie"]
    assert begun.status_code == 204
    assert text.split("_", 2)[2] not in cookie
    assert all(part in cookie for part in ("HttpOnly", "SameSite=strict", "Path=/"))
    found = guarded.get("/v1/session", Cookie=cookie.partition(";")[0])
    assert found.json() == {"needed": True, "name": "anna", "scopes": ["submit"]}
    assert found.headers["Cache-Control"] == "no-store"
    ended = guarded.request("DELETE", "/v1/session")
    assert 'hgs_session=""' in ended.headers["Set-Cookie"]


def test_a_cookie_of_https_stays_there(guarded: Server, keys: FakeKeys) -> None:
    body = {"key": keys.add("anna", Scope.VIEW)}
    assert "Secure" not in guarded.request("POST", "/v1/session", json=body).headers["Set-Cookie"]
    secure = guarded.request("POST", "https://localhost/v1/session", json=body)
    assert "Secure" in secure.headers["Set-Cookie"]


def test_another_text_is_refused(guarded: Server) -> None:
    answer = guarded.request("POST", "/v1/session", json={"key": "hgs_0"})
    assert (answer.status_code, answer.json()["field"]) == (401, "key")
    foreign = guarded.request("POST", "/v1/session", json={"key": "x"}, headers={"Origin": "https://evil.example"})
    assert foreign.status_code == 403


def test_an_open_server_says_that_no_key_is_needed(server: Server) -> None:
    assert server.get("/v1/session").json() == {"needed": False, "name": None, "scopes": []}
