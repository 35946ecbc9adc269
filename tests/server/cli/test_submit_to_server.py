"""`hgs submit --to`, from its own process to a server of another, with lines that break and a server that is killed."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest

from hgs_core.runs.run_folder import RunFolder
from server.cli import main
from server.cli.server_client import Answer, ServerClient
from server.uploads.upload_limits import UploadLimits
from tests.conftest import REPOSITORY

LARGE = 48_000_000


@contextlib.contextmanager
def serving(home: Path, port: int, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "server.cli", "serve", "--workers", "0", "--port", str(port), *arguments]
    environment = {**os.environ, "HGS_HOME": str(home)}
    process = subprocess.Popen(command, cwd=REPOSITORY, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("http")
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        number: int = free.getsockname()[1]
        return number


@contextlib.contextmanager
def cutting(port: int, cuts: list[int]) -> Iterator[str]:
    """A relay before the server that cuts its connections, one by one, after so many bytes of the client's."""
    listener = socket.create_server(("127.0.0.1", 0))

    def relay(client: socket.socket) -> None:
        left = cuts.pop(0) if cuts else None
        with client, contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)) as server:
            threading.Thread(target=answers, args=(server, client), daemon=True).start()
            with contextlib.suppress(OSError):
                while data := client.recv(1 << 16):
                    if left is not None:
                        left -= len(data)
                        if left <= 0:
                            client.shutdown(socket.SHUT_RDWR)
                            return
                    server.sendall(data)

    def answers(server: socket.socket, client: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := server.recv(1 << 16):
                client.sendall(data)
        with contextlib.suppress(OSError):
            client.shutdown(socket.SHUT_RDWR)

    def accept() -> None:
        with contextlib.suppress(OSError):
            while True:
                threading.Thread(target=relay, args=(listener.accept()[0],), daemon=True).start()

    threading.Thread(target=accept, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}"
    finally:
        listener.shutdown(socket.SHUT_RDWR)
        listener.close()


def submit(source: Path, url: str, *more: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "server.cli", "submit", str(source), "--to", url, *more]
    return subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def uploads(url: str) -> list[dict[str, object]]:
    found: list[dict[str, object]] = httpx.get(f"{url}/v1/uploads").json()["uploads"]
    return found


@pytest.mark.slow
def test_cut_lines_and_a_killed_server_cost_nothing(n3dv: Path, home: Path, tmp_path: Path, port: int) -> None:
    (n3dv / "extra.bin").write_bytes(os.urandom(LARGE))
    url = f"http://127.0.0.1:{port}"
    with cutting(port, [3_000_000, 9_000_000, 20_000_000]) as relayed:
        with serving(home, port) as server:
            client = submit(n3dv, relayed, "--title", "Sent", "--trust-poses")
            while not (found := uploads(url)) or int(str(found[0]["received"])) < LARGE // 3:
                assert client.poll() is None, client.communicate()
                time.sleep(0.02)
            server.kill()
            server.wait()
        with serving(home, port):
            output, errors = client.communicate(timeout=240)
            assert client.returncode == 0, errors
            (upload,) = uploads(url)
            capture = Path(str(upload["capture"]))
            assert (upload["state"], capture.parent) == ("finished", home / "uploads" / "captures")
            for file in n3dv.iterdir():
                assert (capture / file.name).read_bytes() == file.read_bytes()
            job = httpx.get(f"{url}/v1/jobs/{output.strip()}").json()
            assert (job["title"], job["capture"], job["config"]["capture"]["trust_poses"]) == (
                "Sent",
                str(capture),
                True,
            )
            assert "camera  partners" in errors
            again = submit(n3dv, url, "--trust-poses", "--audio", "none")
            output, errors = again.communicate(timeout=240)
            assert again.returncode == 0, errors
            assert RunFolder(home / "runs" / output.strip()).read_spec().given.audio == "none"
            assert len(uploads(url)) == 1  # files on the server are not sent again


@pytest.fixture
def refusal(home: Path, port: int, capsys: pytest.CaptureFixture[str]) -> Iterator[Callable[..., str]]:
    """Return a function that submits to a server that takes little, and returns the line of the refusal."""
    with serving(home, port, "--uploads", "file=10k,upload=1M,free=0"):

        def submit_to(source: Path) -> str:
            assert main(["submit", str(source), "--to", f"http://127.0.0.1:{port}"]) == 2
            return capsys.readouterr().err.splitlines()[-1]

        yield submit_to


def test_what_cannot_be_sent_or_trained_is_told_in_one_line(
    n3dv: Path, tmp_path: Path, refusal: Callable[..., str]
) -> None:
    assert "does not exist" in refusal(tmp_path / "missing")
    lonely = tmp_path / "lonely"
    lonely.mkdir()
    assert "the folder is empty" in refusal(lonely)
    shutil.copy(n3dv / "cam00.mp4", lonely)
    assert "1 video but no file of the cameras' poses" in refusal(lonely)
    (lonely / "large").write_bytes(bytes(10_001))
    assert "one file may have 10.0 kB" in refusal(lonely)
    assert main(["submit", str(n3dv), "--to", "ftp://x"]) == 2
    for option in ("--masks", "--depth", "--mesh"):
        assert main(["submit", str(n3dv), "--to", "http://x", option, str(lonely)]) == 2


@pytest.mark.parametrize(("more", "status"), [((), 2), (("--hold-out", "cam01"), 0), (("--trust-poses",), 0)])
def test_a_dead_camera_that_is_held_out_does_not_stop_a_submission(
    n3dv: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], more: tuple[str, ...], status: int
) -> None:
    """The refusal's own cure is taken."""
    black = {"stops": True, "cameras": ["cam01"], "problem": "its pictures are black", "cure": "leave it out"}
    found = {"cameras": [], "findings": [black | {"of_pictures": True}], "frames": [0], "width": 64}
    answers = {
        "/v1/uploads": {"limits": vars(UploadLimits())},
        "/v1/captures": {"captures": []},
        "/v1/captures/check": {"state": "done", "error": None, "found": found},
        "/v1/jobs": {"id": "job", "state": "queued"},
        "/v1/workers": {"workers": [{"alive": True}]},
    }

    def request(self: ServerClient, method: str, path: str, **named: object) -> Answer:
        return Answer(200, httpx.Headers(), answers[path])

    monkeypatch.setattr(ServerClient, "request", request)
    monkeypatch.setattr("server.cli.submit_to_server.send_capture", lambda *of: "sent")
    monkeypatch.setattr("server.cli.submit_to_server.no_worker", lambda *of: "")
    assert main(["submit", str(n3dv), "--to", "http://localhost:9", *more]) == status
    out, err = capsys.readouterr()
    assert out == ("" if status else "job\n")
    assert ("hgs: sent, camera cam01: its pictures are black; leave it out" in err) == bool(status)
