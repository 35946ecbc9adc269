"""Standard output and error: readers that leave, encodings that lack letters, full disks."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

HGS = [sys.executable, "-m", "server.cli"]


def run(command: str, home: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", command, "bash", *HGS],
        cwd=REPOSITORY,
        env={**os.environ, "HGS_HOME": str(home), **environment},
        capture_output=True,
        check=False,
    )


def test_a_reader_that_leaves_early_is_no_fault(home: Path) -> None:
    done = run('"$@" keys ls --json | true; echo "${PIPESTATUS[0]}"', home)
    assert done.stderr == b""
    assert done.stdout in (b"0\n", b"141\n")
    done = run('{ sleep 3; "$@" jobs ls --json; } | true; echo "${PIPESTATUS[0]}"', home)
    assert (done.stdout, done.stderr) == (b"141\n", b"")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux")
def test_an_output_that_is_full_is_told_in_one_line(home: Path) -> None:
    done = run('"$@" jobs ls >/dev/full', home)
    assert done.returncode == 2
    assert done.stderr.startswith(b"hgs: the output: no space left on device")
    assert done.stderr.count(b"\n") == 1


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams_do_no_harm(home: Path, closed: str) -> None:
    assert run(f'"$@" jobs ls {closed}', home).returncode == 0
    done = run(f'"$@" jobs show x {closed}', home)
    assert done.returncode == 2
    assert b"Traceback" not in done.stderr


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_any_text_can_be_written_in_any_encoding(home: Path, encoding: str) -> None:
    settings = {"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0", "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0"}
    done = run("\"$@\" check $'x\\xff\\xe4\\xb8\\xad'", home, **settings)
    assert done.returncode == 2
    assert done.stderr.startswith(rb"hgs: x\xff\xe4\xb8\xad: ")
    assert done.stderr.count(b"\n") == 1
    shown = {"ascii": b"Zo\\xeb", "latin-1": b"Zo\xeb", "utf-8": "Zoë".encode()}
    assert shown[encoding] in run('"$@" keys add Zoë', home, **settings).stderr


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_command_that_waits_ends_at_the_first_signal(home: Path, number: signal.Signals, status: int) -> None:
    line = [*HGS, "jobs", "ls", "--to", "http://127.0.0.1:9", "--patience", "600"]
    with subprocess.Popen(line, cwd=REPOSITORY, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        assert b"cannot be reached (Connection refused), trying again for 10 min" in process.stderr.readline()
        process.send_signal(number)
        assert process.wait(30) == status
        assert process.stderr.read() == b""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_submission_that_reaches_nobody_ends_at_the_first_signal(n3dv: Path, number: signal.Signals) -> None:
    line = [*HGS, "submit", str(n3dv), "--to", "http://127.0.0.1:9", "--patience", "600"]
    with subprocess.Popen(line, cwd=REPOSITORY, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        assert b"trying again for 10 min" in process.stderr.readline()
        process.send_signal(number)
        assert process.wait(30) == 130
        told = process.stderr.read()
        assert b"stopped; run the same command again to go on" in told
        assert b"Traceback" not in told


def test_a_submission_while_it_sends_ends_at_the_first_signal(n3dv: Path, home: Path) -> None:
    """A server that accepts everything and answers nothing."""
    import http.server
    import threading

    class Silent(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def answer(self, body: bytes, status: int = 200) -> None:
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def do_GET(self) -> None:
            limits = b'{"limits": {}, "uploads": []}'
            self.answer(limits)

        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            if self.path == "/v1/uploads":
                self.answer(b'{"id": "u"}', 201)
            else:
                sending.set()
                time.sleep(60)

        def log_message(self, *_: object) -> None:
            pass

    sending = threading.Event()
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Silent) as server:
        server.daemon_threads = True
        server.block_on_close = False
        threading.Thread(target=server.serve_forever, args=(0.01,)).start()
        line = [*HGS, "submit", str(n3dv), "--to", f"http://127.0.0.1:{server.server_port}"]
        with subprocess.Popen(line, cwd=REPOSITORY, stderr=subprocess.PIPE) as process:
            assert process.stderr is not None
            try:
                assert sending.wait(60)
                process.send_signal(signal.SIGTERM)
                assert process.wait(30) == 130
                assert b"stopped; run the same command again to go on" in process.stderr.read()
            finally:
                process.kill()
                server.shutdown()
