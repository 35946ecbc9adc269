from __future__ import annotations

import asyncio
import json
import sys
from pathlib import Path
from typing import Any

import httpx
import pytest

from hgs_core.base.errors import InputError
from server.captures.capture_folders import CaptureFolders
from server.captures.check_requests import CaptureChecks

FOUND = {"cameras": [], "findings": [], "stops": False, "frames": [0], "width": 64, "shown": []}


@pytest.fixture(autouse=True)
def _quick_checks(server: Any) -> None:
    program = f"print({json.dumps(json.dumps(FOUND))})"
    server.app.state.service.capture_checks = CaptureChecks(lambda capture: [sys.executable, "-c", program])


def test_a_check_is_started_and_followed_to_its_end(server: Any) -> None:
    capture = server.home.folder / "uploads" / "captures" / "studio"
    capture.mkdir(parents=True)

    async def scenario() -> None:
        transport = httpx.ASGITransport(server.app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            query = {"capture": str(capture)}
            assert (await client.get("/v1/captures/check", params=query)).status_code == 404
            assert (await client.post("/v1/captures/check", json=query)).status_code == 202
            while (told := (await client.get("/v1/captures/check", params=query)).json())["state"] != "done":
                assert told["state"] in ("waiting", "running")
                await asyncio.sleep(0.02)
            assert (told["capture"], told["error"], told["found"]["width"]) == (str(capture), None, 64)

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("body", "status", "code"),
    [
        ({"capture": "/etc"}, 403, "capture-outside"),
        ({"capture": "missing"}, 422, "capture-invalid"),
        ({"capture": "studio", "more": 1}, 422, "body-invalid"),
    ],
)
def test_what_cannot_be_checked_is_refused(server: Any, body: dict[str, Any], status: int, code: str) -> None:
    answer = server.request("POST", "/v1/captures/check", json=body)
    assert (answer.status_code, answer.json()["code"]) == (status, code)


def test_a_refused_capture_is_named_without_the_server_s_folder(server: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(folders: CaptureFolders, capture: Path) -> None:
        raise InputError(capture / "cam00.mp4", "cannot be read")

    monkeypatch.setattr(CaptureFolders, "require_inner_links", refuse)
    answer = server.request("POST", "/v1/captures/check", json={"capture": "studio"})
    assert (answer.status_code, answer.json()["code"], answer.json()["field"]) == (422, "capture-invalid", "capture")
    assert "studio/cam00.mp4: cannot be read" in answer.json()["detail"]
    assert str(server.captures) not in answer.json()["detail"]
