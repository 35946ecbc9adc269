"""The door of a server that asks for keys: every route, by every way in."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path

import pytest
import websockets
from starlette.routing import BaseRoute, Route, WebSocketRoute
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosedError, InvalidStatus

from jobs.records.keys import Scope
from server.access import door as access_control
from server.access import visitors as access_module
from server.access.scopes import needed_scope
from server.access.signed_tokens import SignedToken, sign_token
from server.access.visitors import COOKIE, Access, Asking
from server.app import create_app
from server.captures.capture_folders import CaptureFolders
from server.protocol.messages import Hello, encode
from tests.server.access_keys import FakeKeys
from tests.server.conftest import FakeArtifacts, FakeJobs, Server, running_server
from tests.server.listener.test_http_server import receive


@pytest.fixture
def keys() -> FakeKeys:
    return FakeKeys()


@pytest.fixture
def now() -> list[float]:
    """The server's clock, to be moved."""
    return [1000.0]


@pytest.fixture
def guarded(
    server: Server,
    keys: FakeKeys,
    now: list[float],
    manifest: bytes,
    chunks: list[bytes],
    monkeypatch: pytest.MonkeyPatch,
) -> Server:
    """The scenes studio and other, which name the same chunks but one, behind keys."""
    monkeypatch.setattr(access_module, "FRESH_SECONDS", 0.0)
    access = Access(keys, Asking.ALWAYS, lambda: now[0])
    jobs, artifacts = FakeJobs(), FakeArtifacts()
    app = create_app(
        server.home,
        captures=CaptureFolders(()),
        job_client=jobs,
        artifacts=artifacts,
        access=access,
        viewer=server.home.folder.parent / "viewer",
    )
    artifacts.manifests = {"studio": manifest, "other": manifest.replace(b"Studio", b"Other")}
    artifacts.thumbnails = {"studio": b"jpeg", "other": b"jpeg"}
    for chunk in chunks:
        artifacts.add_chunk(chunk)
    return Server(app, jobs, artifacts, server.captures, server.home)


def token(scene: str = "studio", expires: int = 2000) -> str:
    return sign_token(SignedToken("link", expires, "", scene), b"s" * 32)


def routes(routes: list[BaseRoute]) -> Iterator[tuple[str, str]]:
    """Every method and path that the application has, with something in place of parameters."""
    for route in routes:
        nested = getattr(route, "routes", None) or getattr(getattr(route, "original_router", None), "routes", None)
        path = getattr(route, "path", "")
        for name in ("scene_id", "job_id", "chunk_id", "upload_id", "number", "path:path"):
            path = path.replace(f"{{{name}}}", 64 * "0" if name == "chunk_id" else "studio")
        if isinstance(route, WebSocketRoute):
            yield "WEBSOCKET", path
        elif isinstance(route, Route):
            yield from ((method, path) for method in sorted(route.methods or ()))
        elif nested:
            yield from globals()["routes"](nested)


PUBLIC = {"/v1/health", "/healthz", "/readyz", "/v1/session", "/studio"}  # the last is a file of the viewer


def test_no_route_answers_without_a_key_but_health_the_session_and_the_viewers_files(guarded: Server) -> None:
    found = list(routes(guarded.app.routes))
    assert len(found) > 25
    assert {path for _, path in found} > PUBLIC
    for method, path in found:
        if method == "WEBSOCKET":
            assert needed_scope(method, path) is not None, path
            continue
        status = guarded.request(method, path).status_code
        assert (status == 401) != (path in PUBLIC), (method, path, status)


def test_a_key_that_may_only_look_changes_nothing(guarded: Server, keys: FakeKeys) -> None:
    bearer = {"Authorization": f"Bearer {keys.add('anna', Scope.VIEW)}"}
    allowed, refused = set(), set()
    for method, path in routes(guarded.app.routes):
        if method != "WEBSOCKET" and path not in PUBLIC:
            status = guarded.request(method, path, headers=bearer).status_code
            (refused if status == 403 else allowed).add(path)
            assert status == 403 or method in ("GET", "HEAD"), (method, path)
    assert {"/v1/jobs", "/v1/captures", "/v1/links"} <= refused
    assert {"/v1/scenes", "/v1/scenes/studio/manifest"} <= allowed
    assert guarded.request("DELETE", "/v1/scenes/studio", headers=bearer).json()["code"] == "not-allowed"


def test_a_refusal_says_what_is_missing(guarded: Server, keys: FakeKeys) -> None:
    answer = guarded.get("/v1/scenes")
    assert (answer.status_code, answer.json()["code"]) == (401, "key-needed")
    assert answer.headers["WWW-Authenticate"].startswith("Bearer")
    answer = guarded.get("/v1/jobs", Authorization=f"Bearer {keys.add('anna', Scope.VIEW)}")
    assert answer.json()["detail"] == "GET /v1/jobs needs the scope submit"


def test_what_needs_a_key_is_kept_out_of_shared_caches(guarded: Server, keys: FakeKeys, chunks: list[bytes]) -> None:
    path = f"/v1/chunks/{hashlib.sha256(chunks[0]).hexdigest()}"
    answer = guarded.get(path, Authorization=f"Bearer {keys.add('anna', Scope.VIEW)}")
    assert answer.headers["Cache-Control"] == "private, max-age=31536000, immutable"
    assert {"Authorization", "Cookie"} <= {name.strip() for name in answer.headers["Vary"].split(",")}


def test_a_link_opens_its_scene_with_all_its_chunks_and_nothing_else(guarded: Server, chunks: list[bytes]) -> None:
    own = f"/v1/chunks/{hashlib.sha256(chunks[2]).hexdigest()}"
    foreign = f"/v1/chunks/{guarded.artifacts.add_chunk(b'of another scene')}"
    link = f"?link={token()}"
    for path in ("/v1/scenes/studio", "/v1/scenes/studio/manifest", "/v1/scenes/studio/thumbnail", own):
        assert guarded.get(path + link).status_code == 200, path
    for path in ("/v1/scenes/other", "/v1/scenes/other/manifest", "/v1/scenes", "/v1/jobs", foreign):
        assert guarded.get(path + link).status_code == 403, path
    assert guarded.request("DELETE", f"/v1/scenes/studio{link}").status_code == 403
    assert guarded.get(own + f"?link={token('nowhere')}").status_code == 403


def test_a_link_ends_to_the_second(guarded: Server, now: list[float]) -> None:
    path = f"/v1/scenes/studio/manifest?link={token(expires=1010)}"
    now[0] = 1009.999
    assert guarded.get(path).status_code == 200
    now[0] = 1010.0
    answer = guarded.get(path)
    assert (answer.status_code, answer.json()["detail"]) == (
        401,
        "this link has expired, or was not made by this server",
    )


def test_a_session_of_a_browser_is_no_use_to_pages_of_other_sites(guarded: Server, keys: FakeKeys) -> None:
    key = keys.add("anna", Scope.ADMIN)
    begun = guarded.request("POST", "/v1/session", json={"key": key})
    assert begun.status_code == 204
    cookie = {"Cookie": f"{COOKIE}={begun.cookies[COOKIE]}"}
    assert guarded.request("GET", "/v1/scenes", headers=cookie).status_code == 200
    foreign = cookie | {"Origin": "https://evil.example"}
    answer = guarded.request("POST", "/v1/jobs/studio/cancel", headers=foreign)
    assert (answer.status_code, answer.json()["code"]) == (403, "origin-not-allowed")


def conversing(guarded: Server, talk: Callable[[str], Awaitable[None]]) -> None:
    async def run() -> None:
        async with running_server(guarded.app) as (_, address):
            await talk(f"ws://{address}/v1/scenes/studio/stream")

    asyncio.run(run())


async def greeted(socket: ClientConnection) -> None:
    await socket.send(encode(Hello(1, 4144)))
    await receive(socket)


def test_a_stream_needs_a_key_or_a_link_to_its_scene(guarded: Server, keys: FakeKeys) -> None:
    async def talk(url: str) -> None:
        for query, status in (("", 401), (f"?link={token('other')}", 403), ("?link=x", 401)):
            with pytest.raises(InvalidStatus) as refused:
                await websockets.connect(url + query).__aenter__()
            assert refused.value.response.status_code == status
        async with websockets.connect(f"{url}?link={token()}") as socket:
            await greeted(socket)
        bearer = {"Authorization": f"Bearer {keys.add('anna', Scope.VIEW)}"}
        async with websockets.connect(url, additional_headers=bearer) as socket:
            await greeted(socket)

    conversing(guarded, talk)


@pytest.mark.parametrize("way", ["link", "key"])
def test_an_open_stream_ends_with_what_opened_it(
    guarded: Server, keys: FakeKeys, now: list[float], monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    monkeypatch.setattr(access_control, "CHECK_SECONDS", 0.01)
    bearer = {"Authorization": f"Bearer {keys.add('anna', Scope.VIEW)}"} if way == "key" else {}

    async def talk(url: str) -> None:
        async with websockets.connect(
            url + ("" if bearer else f"?link={token()}"), additional_headers=bearer
        ) as socket:
            await greeted(socket)
            keys.keys.clear()
            now[0] = 2000.0
            received = []
            with contextlib.suppress(ConnectionClosedError):
                async for message in socket:
                    received.append(message)
            assert b"access-ended" in received[-1]
            assert socket.close_code == 4003

    conversing(guarded, talk)


def test_without_the_database_of_keys_the_answer_says_so(guarded: Server, keys: FakeKeys) -> None:
    from sqlalchemy.exc import OperationalError

    keys.fault = OperationalError("", {}, Exception("gone"))
    answer = guarded.get("/v1/scenes")
    assert (answer.status_code, answer.headers["Retry-After"]) == (503, "5")
    assert guarded.get("/v1/health").status_code == 200


def test_a_server_that_asks_nobody_is_as_it_was(server: Server, manifest: bytes, tmp_path: Path) -> None:
    server.artifacts.manifests["studio"] = manifest
    answer = server.get("/v1/scenes/studio/manifest")
    assert answer.status_code == 200
    assert "Cookie" not in answer.headers.get("Vary", "")
