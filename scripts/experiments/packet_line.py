"""A line that loses and delays packets, between two network namespaces; for measuring, with root's rights on Linux.

Each namespace has a TUN device; this process carries the IP packets from one to the other, as a router would: a queue
of a given rate that drops what does not fit, a delay, and losses by chance. What TCP or QUIC makes of that is the
kernel's or the library's own doing: nothing of them is imitated, which a relay of bytes would have to.
"""

from __future__ import annotations

import ctypes
import fcntl
import heapq
import math
import os
import random
import select
import socket
import struct
import subprocess
import time
from collections import deque
from dataclasses import dataclass

CLONE_NEWNET = 0x40000000
TUNSETIFF = 0x400454CA
IFF_TUN, IFF_NO_PI = 0x0001, 0x1000
SERVER, CLIENT = "10.77.0.1", "10.77.0.2"
LONGEST_PACKET = 1500


@dataclass(frozen=True)
class Line:
    """What a line does to packets in each direction; all of them pass the queue, of which the server's side fills."""

    mbit: float
    trip: float  # seconds, there and back, of an empty line
    loss: float  # share of the packets

    @property
    def queue_bytes(self) -> int:
        """Of the queue: what the line carries in a round trip, or in 100 ms if that is more."""
        return int(self.mbit * 1e6 / 8 * max(self.trip, 0.1))


def enter_namespace(end: socket.socket, address: str) -> None:
    """Put this process into a network namespace of its own, and send its TUN device over `end`."""
    if ctypes.CDLL(None, use_errno=True).unshare(CLONE_NEWNET):
        raise OSError(ctypes.get_errno(), "a network namespace needs root's rights")
    device = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH", b"line", IFF_TUN | IFF_NO_PI))
    for command in ("link set lo up", f"address add {address}/24 dev line", "link set line up"):
        subprocess.run(["ip", *command.split()], check=True)
    socket.send_fds(end, [b"line"], [device])
    os.close(device)


def receive_device(end: socket.socket) -> int:
    """Return the device that `enter_namespace` has sent."""
    _, devices, _, _ = socket.recv_fds(end, 16, 1)
    os.set_blocking(devices[0], False)
    return devices[0]


class _Direction:
    """Packets on their way from one device to the other."""

    def __init__(self, line: Line, source: int, target: int, dice: random.Random) -> None:
        self.source = source
        self._line, self._target, self._dice = line, target, dice
        self._queue: deque[tuple[float, bytes]] = deque()  # when the line has carried it, and the packet
        self._queued = 0
        self._free = 0.0  # when the line has carried all that is queued
        self._flying: list[tuple[float, int, bytes]] = []
        self._count = 0
        self.lost = self.dropped = 0

    def take(self, now: float) -> None:
        """Take what the source has."""
        while True:
            try:
                packet = os.read(self.source, LONGEST_PACKET)
            except BlockingIOError:
                return
            if self._queued + len(packet) > self._line.queue_bytes:
                self.dropped += 1
                continue
            self._free = max(self._free, now) + 8 * len(packet) / (self._line.mbit * 1e6)
            self._queue.append((self._free, packet))
            self._queued += len(packet)

    def give(self, now: float) -> None:
        """Let the target have what has come through."""
        while self._queue and self._queue[0][0] <= now:
            carried, packet = self._queue.popleft()
            self._queued -= len(packet)
            if self._dice.random() < self._line.loss:
                self.lost += 1
            else:
                self._count += 1
                heapq.heappush(self._flying, (carried + self._line.trip / 2, self._count, packet))
        while self._flying and self._flying[0][0] <= now:
            os.write(self._target, heapq.heappop(self._flying)[2])

    def due(self) -> float:
        """Return when there is something to do again."""
        return min((waiting[0][0] for waiting in (self._queue, self._flying) if waiting), default=math.inf)


def carry(line: Line, devices: tuple[int, int], seed: int, ended: int) -> tuple[int, int]:
    """Carry packets between two devices until the file `ended` can be read; return how many were lost and dropped."""
    directions = [
        _Direction(line, *devices, random.Random(seed)),
        _Direction(line, *devices[::-1], random.Random(-seed)),
    ]
    while True:
        now = time.monotonic()
        for direction in directions:
            direction.give(now)
        wait = min(direction.due() for direction in directions) - time.monotonic()
        ready, _, _ = select.select([*devices, ended], [], [], min(max(wait, 0.0), 0.5))
        if ended in ready:
            return sum(one.lost for one in directions), sum(one.dropped for one in directions)
        for direction in directions:
            if direction.source in ready:
                direction.take(time.monotonic())
