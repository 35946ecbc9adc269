"""A machine that can vanish: a network namespace with a cable to this one that can be pulled. Needs root on Linux."""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
from pathlib import Path
from types import TracebackType
from typing import Self

_numbers = itertools.count()


class NetworkNode:
    """A network namespace; `address` is this machine's as the node sees it."""

    def __init__(self) -> None:
        number = next(_numbers)
        self._name = f"hgs-{os.getpid()}-{number}"
        self._here, self._there = f"h{os.getpid()}n{number}a", f"h{os.getpid()}n{number}b"  # 15 characters at most
        network = f"10.{200 + number % 50}.{os.getpid() % 256}"
        self.address, self._own = f"{network}.1", f"{network}.2"

    def __enter__(self) -> Self:
        for command in (
            f"netns add {self._name}",
            f"link add {self._here} type veth peer name {self._there} netns {self._name}",
            f"addr add {self.address}/30 dev {self._here}",
            f"link set {self._here} up",
            f"-n {self._name} addr add {self._own}/30 dev {self._there}",
            f"-n {self._name} link set {self._there} up",
            f"-n {self._name} link set lo up",
        ):
            _ip(command)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        _ip(f"link del {self._here}")
        _ip(f"netns del {self._name}")

    def start(self, *command: str, env: dict[str, str] | None = None) -> subprocess.Popen[bytes]:
        """Start a program on the node."""
        return subprocess.Popen(self.there(*command), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, env=env)

    def there(self, *command: str) -> list[str]:
        """Return the command that runs a program on the node, in the same process."""
        return ["ip", "netns", "exec", self._name, *command]

    def pull_the_cable(self) -> None:
        """Drop all packets from now on, in both directions and without a word to either side."""
        _ip(f"-n {self._name} link set {self._there} down")

    def plug_it_in(self) -> None:
        """Let packets pass again."""
        _ip(f"-n {self._name} link set {self._there} up")


def why_no_nodes() -> str:
    """Return why no node can be made here; "" if one can."""
    if os.geteuid() != 0 or shutil.which("ip") is None or not Path("/proc/self/ns/net").exists():
        return "making a network namespace takes root and the program ip (package iproute2)"
    name = f"hgs-{os.getpid()}-probe"
    made = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True, check=False)
    if made.returncode != 0:
        return f"no network namespace can be made here: {made.stderr.strip()}"
    _ip(f"netns del {name}")
    return ""


def _ip(command: str) -> None:
    subprocess.run(["ip", *command.split()], check=True)
