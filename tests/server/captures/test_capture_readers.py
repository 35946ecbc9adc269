from __future__ import annotations

import json
import logging
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from server.captures.capture_readers import CaptureReaders, ReaderEndedError, answered
from server.http.problem_error import ProblemError


def readers(program: str, home: Path) -> CaptureReaders:
    """Readers that run a program of Python; it has the operation and the descriptor of the note as arguments."""
    return CaptureReaders(Home.at(home), lambda operation, note: [sys.executable, "-c", program, operation, str(note)])


def test_a_reader_has_the_request_and_its_answers_come_one_by_one(tmp_path: Path) -> None:
    program = """
import json, sys
asked = json.loads(sys.stdin.readline())
for number in range(asked["most"]):
    print(json.dumps({"found": [sys.argv[1], number]}), flush=True)
"""
    told = list(readers(program, tmp_path).read("describe", {"most": 3}, 600))
    assert told == [{"found": ["describe", number]} for number in range(3)]


def test_answers_of_a_reader_that_ended_before_the_request_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Ended(subprocess.Popen[bytes]):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            self.wait()

    monkeypatch.setattr(subprocess, "Popen", Ended)
    assert list(readers("print('{}')", tmp_path).read("describe", {}, 600)) == [{}]


@pytest.mark.parametrize(
    ("program", "reason"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", r"reading it crashed the reader process \(SIGSEGV\)"),
        ("os.kill(os.getpid(), signal.SIGXCPU)", "takes more processor time to read than a capture may"),
        ("raise SystemExit(3)", r"reading it crashed the reader process \(status 3\)"),
    ],
)
def test_a_reader_that_ends_says_how_and_by_which_file(tmp_path: Path, program: str, reason: str) -> None:
    program = f"import os, signal, sys; os.pwrite(int(sys.argv[2]), b'/all/a/b.mp4', 0); {program}"
    with pytest.raises(ReaderEndedError, match=reason) as raised:
        list(readers(program, tmp_path).read("describe", {}, 600))
    told = raised.value.of(Path("/all/a"))
    assert (told.where, told.cure) == ("/all/a/b.mp4", "export the file again, or leave it out")
    assert raised.value.of(Path("/all/c")).where == "/all/c"  # the file is none of that capture


def test_a_reader_that_does_not_answer_is_ended(tmp_path: Path) -> None:
    with pytest.raises(ReaderEndedError, match=r"takes longer to read than 0 s"):
        list(readers("import time; time.sleep(3600)", tmp_path).read("describe", {}, 0.05))


def test_a_server_that_stops_ends_its_readers(tmp_path: Path) -> None:
    some = readers("print('{}', flush=True)\nimport time; time.sleep(3600)", tmp_path)
    began, ended = threading.Event(), threading.Event()

    def read() -> None:
        try:
            for _ in some.read("create", {}, 3600):
                began.set()
        except ReaderEndedError:
            ended.set()

    thread = threading.Thread(target=read)
    thread.start()
    began.wait()
    some.close()
    thread.join()
    assert ended.is_set()
    with pytest.raises(ReaderEndedError):  # none is begun any more
        list(some.read("create", {}, 3600))


def test_a_reader_has_none_of_the_servers_secrets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "p4ss")
    monkeypatch.setenv("HGS_DATABASE_URL", "postgresql://hgs:p4ss@host/hgs")
    program = "import json, os; print(json.dumps(dict(os.environ)))"
    (told,) = readers(program, tmp_path).read("describe", {}, 600)
    assert "p4ss" not in json.dumps(told)
    assert told["HGS_HOME"] == str(tmp_path)


def test_what_a_reader_says_aloud_is_in_the_log(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        list(readers("import sys; sys.exit(print('a trace', file=sys.stderr))", tmp_path).read("create", {}, 600))
    assert "captures, create: a trace" in caplog.text


@pytest.mark.parametrize(
    ("answer", "kind", "words"),
    [
        ({"refused": ["/all/a/b.mp4", "is short", "copy it"]}, InputError, "/all/a/b.mp4: is short; copy it"),
        ({"unreadable": "is nested", "file": "/all/a/t.json"}, InputError, "/all/a/t.json: is nested; export the file"),
        ({"unreadable": "is nested", "file": "/etc/passwd"}, InputError, "/all/a: is nested; export"),
        ({"problem": {"status": 403, "code": "capture-outside", "detail": "a link"}}, ProblemError, "a link"),
        ({"errno": 28, "error": "full"}, OSError, "full"),
    ],
)
def test_what_is_wrong_with_a_capture_is_raised(answer: dict[str, Any], kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words):
        answered(answer, Path("/all/a"))
    assert answered({"found": {"frames": 3}}, Path("/all/a")) == {"frames": 3}
