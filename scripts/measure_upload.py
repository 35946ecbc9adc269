"""The cost of an upload over a line that breaks: repeated bytes, seconds, and the server's memory.

    python -m scripts.measure_upload [--megabytes 2000] [--files 20] [--cuts 5]

Random files are sent with the client of `hgs submit --to` to a server of another process, through a relay that cuts all
connections at even distances. A second folder of as many small files tells what a file costs.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from server.cli.capture_files import capture_files
from server.cli.send_capture import send_capture
from server.cli.server_client import ServerClient

__all__ = ["main"]

_BLOCK = 1 << 16  # bytes that the relay passes on at once


class _Relay:
    """A relay that counts the client's bytes and cuts all connections after every `distance` bytes."""

    def __init__(self, port: int, distance: int, cuts: int) -> None:
        self.sent, self.cuts = 0, 0
        self._port, self._next, self._distance, self._most = port, distance, distance, cuts
        self._open: set[socket.socket] = set()
        self._lock = threading.Lock()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            client, _ = self._listener.accept()
            server = socket.create_connection(("127.0.0.1", self._port))
            with self._lock:
                self._open |= {client, server}
            for source, target, counted in ((client, server, True), (server, client, False)):
                threading.Thread(target=self._pass_on, args=(source, target, counted), daemon=True).start()

    def _pass_on(self, source: socket.socket, target: socket.socket, counted: bool) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(_BLOCK):
                if counted:
                    self._count(len(data))
                target.sendall(data)
        self._cut({source, target})

    def _count(self, size: int) -> None:
        with self._lock:
            self.sent += size
            if self.cuts == self._most or self.sent < self._next:
                return
            self.cuts, self._next = self.cuts + 1, self._next + self._distance
            cut, self._open = self._open, set()
        self._cut(cut)

    def _cut(self, sockets: set[socket.socket]) -> None:
        with self._lock:
            self._open -= sockets
        for one in sockets:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def _serving(home: Path) -> Iterator[tuple[int, int]]:
    """Yield the process and the port of a server."""
    command = [sys.executable, "-m", "server.cli", "serve", "--workers", "0", "--port", "0", "--uploads", "free=0"]
    environment = os.environ | {"HGS_HOME": str(home)}
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield process.pid, int(process.stdout.readline().rpartition(":")[2].strip().rstrip("/"))
    finally:
        process.terminate()
        process.communicate()


def _memory(process: int, kind: str) -> float:
    """Return the memory of a process in MiB: `VmRSS` now, `VmHWM` the most there was."""
    found = re.search(rf"{kind}:\s+(\d+) kB", Path(f"/proc/{process}/status").read_text())
    assert found is not None
    return int(found[1]) / 1024


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--megabytes", type=int, default=2000)
    parser.add_argument("--files", type=int, default=20)
    parser.add_argument("--cuts", type=int, default=5)
    options = parser.parse_args()
    size = options.megabytes * 1_000_000
    with tempfile.TemporaryDirectory(prefix="hgs-upload-") as temporary:
        folder, small, home = (Path(temporary) / name for name in ("large", "small", "home"))
        for one, each in ((folder, size // options.files), (small, 1000)):
            one.mkdir()
            for number in range(options.files if one is folder else 1000):
                with (one / f"cam{number:04}.mp4").open("wb") as file:
                    for start in range(0, each, 1 << 20):
                        file.write(os.urandom(min(1 << 20, each - start)))
        with _serving(home) as (process, port):
            before = _memory(process, "VmRSS")
            relay = _Relay(port, size // (options.cuts + 1), options.cuts)
            with ServerClient(relay.url) as client:
                began = time.monotonic()
                send_capture(client, "large", capture_files(folder), lambda done, total: None)
                seconds = time.monotonic() - began
            most = _memory(process, "VmHWM")
            twice = relay.sent - size
            told = f"{size / 1e6:.0f} MB in {options.files} files, {relay.cuts} cuts"
            print(f"{told}: {seconds:.0f} s, {twice / 1e6:.1f} MB more")
            print(f"the server's memory: {before:.0f} MiB before, at most {most:.0f} MiB")
            with ServerClient(f"http://127.0.0.1:{port}") as client:
                began = time.monotonic()
                send_capture(client, "small", capture_files(small), lambda done, total: None)
                print(f"1000 files of 1 kB: {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main()
