"""The first command of the README, as a stranger runs it."""

from __future__ import annotations

import contextlib
import http.server
import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from scripts import demo
from tests.conftest import REPOSITORY


class Service(http.server.BaseHTTPRequestHandler):
    """A service that answers with the next state of the job, and notes submissions."""

    scenes: list[str] = []  # noqa: RUF012
    jobs: list[dict[str, Any]] = []  # noqa: RUF012
    course: list[dict[str, Any]] = []  # noqa: RUF012
    submitted: list[dict[str, Any]] = []  # noqa: RUF012
    looks: list[dict[str, Any]] = []  # noqa: RUF012

    def do_GET(self) -> None:
        if self.path == "/v1/scenes":
            self._answer({"scenes": [{"id": one} for one in self.scenes]})
        elif self.path == "/v1/jobs":
            self._answer({"jobs": self.jobs})
        elif self.path == "/v1/submissions/look-1":
            self._answer(self.looks.pop(0) if self.looks else job("queued", attempt=0))
        else:
            self._answer(self.course.pop(0) if len(self.course) > 1 else self.course[0])

    def do_POST(self) -> None:
        self.submitted.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
        self._answer({"id": "look-1", "state": "looking"})

    def log_message(self, *_: object) -> None:
        pass

    def _answer(self, value: Any) -> None:
        body = json.dumps(value).encode()
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


def job(state: str, stage: str = "", done: int = 0, **fields: Any) -> dict[str, Any]:
    progress = {"stage": stage, "done": done, "total": 10, "figures": {"psnr": 20.0}} if stage else None
    told = {"id": "studio-1", "title": demo.TITLE, "state": state, "scene": None, "error": None, "progress": progress}
    return told | fields


@pytest.fixture
def service(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    for name in ("scenes", "jobs", "course", "submitted", "looks"):
        monkeypatch.setattr(Service, name, [])
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Service) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,)).start()
        with contextlib.suppress(BrokenPipeError):
            yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def test_it_says_how_long_and_where_before_it_begins(service: str, capsys: pytest.CaptureFixture[str]) -> None:
    Service.course += [
        job("queued"),
        job("running", "masks", 3),
        job("running", "train", 5),
        job("succeeded", "train", 10),
    ]
    made, kept = demo.scene_of(service)
    assert (made["state"], kept) == ("succeeded", False)
    assert [one["capture"] for one in Service.submitted] == ["studio"]
    told = capsys.readouterr().err
    first, *rest = told.replace("\r", "\n").splitlines()
    assert first.startswith("training Studio: about ")
    assert "idle core" in first
    assert first.endswith(f"page at {service}/view/studio-1")
    for words in ("waits for the worker", "masks", "train", "psnr=20"):
        assert words in "\n".join(rest)


def test_a_second_start_has_the_scene_at_once(service: str, capsys: pytest.CaptureFixture[str]) -> None:
    Service.scenes += ["studio-1"]
    Service.jobs += [job("failed"), job("succeeded", scene="studio-1"), job("succeeded", title="Other", scene="other")]
    made, kept = demo.scene_of(service)
    assert (made["scene"], kept) == ("studio-1", True)
    assert Service.submitted == []
    assert capsys.readouterr().err == "the scene is there already\n"


@pytest.mark.parametrize("state", ["queued", "running", "waiting"])
def test_a_start_after_a_stop_goes_on_with_the_job(service: str, state: str) -> None:
    Service.jobs += [job(state)]
    Service.course += [job("succeeded", "publish", 10)]
    assert demo.scene_of(service)[0]["state"] == "succeeded"
    assert Service.submitted == []


@pytest.mark.parametrize("earlier", [job("failed"), job("cancelled"), job("succeeded", scene="taken-back")])
def test_a_job_without_a_scene_is_made_anew(service: str, earlier: dict[str, Any]) -> None:
    Service.jobs += [earlier]
    Service.course += [job("succeeded")]
    demo.scene_of(service)
    assert len(Service.submitted) == 1


def test_a_job_that_fails_says_why(service: str) -> None:
    Service.course += [job("running", "train", 2), job("failed", error="train: out of memory")]
    with pytest.raises(SystemExit, match="the demo's job failed: train: out of memory"):
        demo.scene_of(service)


def test_what_is_waited_for_is_said_again_and_again(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demo, "LINE_EVERY", 0.01)
    told = ""
    with demo.waiting("starting the server"):
        while told.count("starting the server: ") < 2:
            time.sleep(0.01)
            told += capsys.readouterr().err
    assert told.startswith("starting the server\n")


def test_a_stage_that_says_nothing_has_a_bar_that_moves(
    service: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demo, "LINE_EVERY", 0.0)
    Service.course += [job("running", "points", 1)] * 4 + [job("succeeded", "points", 1)]
    demo.follow(service, "studio-1", 0.0)
    assert capsys.readouterr().err.count("points:  10%") >= 4


def test_a_server_that_ends_shows_its_last_words(tmp_path: Path) -> None:
    (tmp_path / "demo.log").write_text("hgs: --port: 80 is in use; give another\n")
    with subprocess.Popen([sys.executable, "-c", "raise SystemExit(2)"]) as server:
        server.wait()
        with pytest.raises(SystemExit, match="80 is in use; give another\nthe server ended with status 2"):
            demo.wait_for("http://127.0.0.1:9", server, tmp_path / "demo.log")


@pytest.mark.parametrize(("cores", "minutes"), [(1, "10 minutes on 1 idle core"), (2, "5 minutes on 2 idle cores")])
def test_the_estimate_is_for_the_machine(cores: int, minutes: str) -> None:
    assert demo.estimate(cores) == f"about {minutes}"


@pytest.mark.slow
def test_the_demo_checks_itself_and_keeps_its_run() -> None:
    for again in (False, True):
        result = subprocess.run(
            [REPOSITORY / "scripts" / "demo", "--check"], capture_output=True, text=True, check=False, timeout=900
        )
        assert result.returncode == 0, result.stderr[-2000:]
        report = json.loads(result.stdout.splitlines()[-1])
        assert report["ok"]
        assert report["splats_dynamic"] > 0
        if again:
            assert report["seconds_to_scene"] is None
