from __future__ import annotations

import asyncio
import subprocess
import sys
from pathlib import Path
from typing import Any

import httpx
import pytest

from jobs.home.home import Home
from server.app import create_app

REPOSITORY = Path(__file__).resolve().parents[2]

SERVE_ONE_REQUEST_OF_EACH_KIND = """
import asyncio, sys
from pathlib import Path
import httpx
from jobs.home.home import Home
from server.app import create_app
from jobs.artifacts.publish_run import publish_run
from jobs.artifacts.artifact_store import ArtifactStore

home = Home.at(Path(sys.argv[1]))
publish_run(ArtifactStore(home.store_url), Path(sys.argv[2]), "studio")
app = create_app(home)

async def main():
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
        assert (await client.get("/v1/scenes/studio")).status_code == 200
        assert (await client.get("/v1/jobs")).json() == {"jobs": [], "next": None}
        (home.folder / "captures" / "empty").mkdir(parents=True)
        assert (await client.post("/v1/jobs", json={"capture": "empty"})).json()["code"] == "capture-invalid"

asyncio.run(main())
import server.cli.program  # which `hgs serve` runs

print(*(name for name in ("torch", "pycolmap", "av", "PIL", "cv2") if name in sys.modules))
"""


def test_api_process_never_imports_torch_or_what_opens_captures(tmp_path: Path, scene_folder: Path) -> None:
    process = subprocess.run(
        [sys.executable, "-c", SERVE_ONE_REQUEST_OF_EACH_KIND, str(tmp_path / "home"), str(scene_folder)],
        capture_output=True,
        text=True,
        timeout=120,
        cwd=REPOSITORY,
    )
    assert process.returncode == 0, process.stderr
    assert process.stdout.strip() == ""


def test_no_request_is_told_to_a_tracer_of_the_process(
    tmp_path: Path, server: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Addresses of links hold tokens, and the web framework traces requests unless it is told not to."""
    asked: list[str] = []

    class Recorder:
        def __getattr__(self, name: str) -> Any:
            asked.append(name)
            raise AttributeError(name)

    for signal, provider in (("trace", "tracer"), ("metrics", "meter"), ("_logs", "logger")):
        monkeypatch.setattr(f"opentelemetry.{signal}.get_{provider}_provider", Recorder)
    app = create_app(Home.at(tmp_path), job_client=server.jobs, artifacts=server.artifacts)

    async def status() -> int:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
            return (await client.get("/healthz?link=secret")).status_code

    assert asyncio.run(status()) == 200
    assert asked == []


def test_allowed_origins_may_read_and_not_write(tmp_path: Path, server: Any) -> None:
    app = create_app(
        Home.at(tmp_path), job_client=server.jobs, artifacts=server.artifacts, origins=["https://a.example"]
    )

    async def scenario() -> None:
        headers = {"Origin": "https://a.example"}
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
            read = await client.get("/v1/scenes", headers=headers)
            assert read.headers["access-control-allow-origin"] == "https://a.example"
            asks = {**headers, "Access-Control-Request-Method": "POST"}
            assert (await client.options("/v1/jobs", headers=asks)).status_code == 400

    asyncio.run(scenario())
