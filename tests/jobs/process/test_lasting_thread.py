from __future__ import annotations

import logging
import threading

import pytest

from jobs.process import lasting_thread as module
from jobs.process.lasting_thread import lasting_thread


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PAUSE", 0.0)


@pytest.mark.parametrize(
    "error", [OSError("cannot sleep"), ValueError(), RuntimeError("x"), MemoryError(), SystemExit()]
)
def test_a_thread_that_dies_runs_again_and_the_log_says_so(
    error: BaseException, caplog: pytest.LogCaptureFixture
) -> None:
    tries: list[int] = []

    def work() -> None:
        tries.append(1)
        if len(tries) < 3:
            raise error

    with caplog.at_level(logging.ERROR):
        thread = lasting_thread("webhooks", work)
        thread.start()
        thread.join(60)
    assert len(tries) == 3
    assert [record.getMessage() for record in caplog.records] == [
        "the thread 'webhooks' has died; it goes on in 0 s"
    ] * 2


def test_it_goes_on_where_even_waiting_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    done = threading.Event()
    tries: list[int] = []

    class Broken(threading.Event):
        def wait(self, timeout: float | None = None) -> bool:
            if threading.current_thread() is thread and tries:
                raise OSError("cannot wait")
            return super().wait(timeout)

    def work() -> None:
        tries.append(1)
        if len(tries) < 3:
            raise OSError("no memory")
        done.set()

    thread = lasting_thread("x", work)
    monkeypatch.setattr(threading, "Event", Broken)
    thread.start()
    assert done.wait(60)
