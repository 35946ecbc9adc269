"""A server in a process of its own that reports its cost: processor time, its memory, and the kernel's for it."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import os
import resource
import socket
import struct
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.codec.format.manifest import Manifest
from server.bench.bench_scene import BenchScene, made_up_scene, scene_of
from server.bench.one_scene_server import serving
from server.listener.connection_limits import raise_open_file_limit
from server.listener.http_server import spare_collector

__all__ = ["BenchServer", "Costs"]

SO_MEMINFO = 55  # Linux: what a socket holds, as unsigned integers
RECEIVED, QUEUED, SPARE = 0, 5, 4  # places in it, bytes


@dataclass(frozen=True)
class Costs:
    """Of a server so far."""

    processor: float  # seconds
    memory: int  # bytes that the process holds
    connections: int
    kernel: int  # bytes that the kernel holds for all connections; 0 where it does not tell


class BenchServer:
    """Serves a scene as `bench`, on a free port of this machine, until it is closed."""

    def __init__(self, scene: Path | None, minutes: float) -> None:
        """Serve the scene of a folder, or else a made-up one of so many minutes.

        Raises:
            InputError: the folder has no manifest of a scene, or a chunk cannot be read.
            RuntimeError: the server has not begun to serve; it has told why on standard error.
        """
        spawn = multiprocessing.get_context("spawn")
        self._pipe, theirs = spawn.Pipe()
        self._process = spawn.Process(target=_serve, args=(theirs, scene, minutes), daemon=True)
        self._process.start()
        theirs.close()  # else its end would not be noticed
        self.port: int
        self.manifest: Manifest
        try:
            begun = self._pipe.recv()
        except EOFError as error:
            raise RuntimeError("the server to be measured has ended before it served; see above") from error
        if isinstance(begun, InputError):
            raise begun
        self.port, self.manifest = begun

    @property
    def url(self) -> str:
        """The address of the scene's stream."""
        return f"ws://127.0.0.1:{self.port}/v1/scenes/bench/stream"

    async def costs(self) -> Costs:
        """Return its cost so far."""
        self._pipe.send("costs")
        costs: Costs = await asyncio.to_thread(self._pipe.recv)
        return costs

    def close(self) -> None:
        """Stop it."""
        self._pipe.close()
        self._process.join(30)
        self._process.kill()


def _serve(pipe: Connection, folder: Path | None, minutes: float) -> None:
    raise_open_file_limit()
    try:
        scene = made_up_scene(round(60 * minutes)) if folder is None else scene_of(folder)
    except InputError as error:
        pipe.send(error)
    else:
        asyncio.run(_tell(pipe, scene))


async def _tell(pipe: Connection, scene: BenchScene) -> None:
    async with serving(scene) as port:
        spare_collector()
        pipe.send((port, scene.manifest))
        with contextlib.suppress(EOFError, ConnectionError):  # whoever measures has gone
            while await asyncio.to_thread(pipe.recv):
                pipe.send(_costs())


def _costs() -> Costs:
    used = resource.getrusage(resource.RUSAGE_SELF)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    held = _sockets()
    return Costs(used.ru_utime + used.ru_stime, pages * os.sysconf("SC_PAGE_SIZE"), len(held), sum(held))


def _sockets() -> list[int]:
    """Return how many bytes the kernel holds for each connection of this process."""
    found = []
    for file in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):
            copy = os.dup(int(file.name))
            try:
                one = socket.socket(fileno=copy)
            except OSError:  # a file
                os.close(copy)
                continue
            with one:
                one.getpeername()
                info = struct.unpack("9I", one.getsockopt(socket.SOL_SOCKET, SO_MEMINFO, 36))
                if one.family == socket.AF_INET:
                    found.append(info[RECEIVED] + info[QUEUED] + info[SPARE])
    return found
