from __future__ import annotations

import os
import socket
import threading
import time
from pathlib import Path

from benchmarks.soak.process_curves import Curves, sample_of


def own() -> tuple[int, int, int]:
    sample = sample_of(os.getpid(), 1.0)
    assert sample is not None
    assert sample.memory > 1
    return sample.files, sample.threads, sample.connections


def test_files_threads_and_connections_are_counted() -> None:
    files, threads, connections = own()
    over = threading.Event()
    thread = threading.Thread(target=over.wait)
    with socket.socket():
        thread.start()
        assert own() == (files + 1, threads + 1, connections + 1)
    over.set()
    thread.join()


def test_a_process_that_is_gone_has_no_sample() -> None:
    assert sample_of(2**22 + 1, 0.0) is None


def test_curves_follow_processes_and_folders(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(bytes(1 << 20))
    curves = Curves(lambda: {"self": os.getpid()}, {"folder": tmp_path}, lambda: 5.0)
    curves.start()
    deadline = time.monotonic() + 120
    while not (curves.samples and curves.disk["folder"]):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    curves.stop()
    assert curves.samples["self"][0].pid == os.getpid()
    assert curves.disk["folder"][0] == (5.0, 1.0)
