"""How much memory a viewer costs the server, and how a server that stops lets its viewers go.

    python -m scripts.measure_streams RUN --viewers 800 --drain 5

Starts `hgs serve` with a run, connects that many streams that take everything and stay, and stops the server. Viewers
share this process, so that their number is bounded by its open files.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import websockets
from websockets.asyncio.client import ClientConnection

from server.protocol.messages import Hello, encode

TOGETHER = 50  # viewers that connect at once
WINDOW = 1 << 20  # bytes of credit


def main() -> None:
    """Measure, and print two lines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="folder of a finished run")
    parser.add_argument("--viewers", type=int, default=800)
    parser.add_argument("--drain", type=float, default=5.0, help="seconds")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as home:
        command = [sys.executable, "-m", "server.cli", "serve", str(options.run), "--port", "0", "--workers", "0"]
        server = subprocess.Popen(
            [*command, "--drain", str(options.drain)],
            env=os.environ | {"HGS_HOME": home},
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        try:
            assert server.stdout is not None
            address, _, scene = server.stdout.readline().strip().partition("/view/")
            url = f"{address.replace('http', 'ws', 1)}/v1/scenes/{scene}/stream"
            asyncio.run(_watch(server, url, options.viewers))
        finally:
            server.kill()
            server.wait()


async def _watch(server: subprocess.Popen[str], url: str, viewers: int) -> None:
    joined = [await _join(url)]
    before = _resident(server.pid)
    while len(joined) <= viewers:
        joined += await asyncio.gather(*(_join(url) for _ in range(TOGETHER)))
    await asyncio.sleep(2)
    more = len(joined) - 1
    each = (_resident(server.pid) - before) / more
    print(f"{more} viewers: {before >> 20} MiB of the server before them, {each / 1024:.0f} KiB each")
    stopped = time.monotonic()
    server.send_signal(signal.SIGTERM)
    ends = sorted(await asyncio.gather(*(_end(viewer, stopped) for viewer in joined)))
    server.wait()
    codes = sorted({viewer.close_code for viewer in joined if viewer.close_code is not None})
    middle = ends[len(ends) // 2]
    ended = time.monotonic() - stopped
    print(f"closed with {codes} after {ends[0]:.2f}, {middle:.2f}, {ends[-1]:.2f} s; it ended at {ended:.2f} s")


async def _join(url: str) -> ClientConnection:
    viewer = await websockets.connect(url, max_size=None)
    await viewer.send(encode(Hello(1, WINDOW)))
    await viewer.recv()
    return viewer


async def _end(viewer: ClientConnection, since: float) -> float:
    """Read to the end; return when it came."""
    try:
        async for _ in viewer:
            pass
    except websockets.ConnectionClosedError:
        pass
    return time.monotonic() - since


def _resident(process: int) -> int:
    """Return the bytes of memory that a process holds."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


if __name__ == "__main__":
    main()
