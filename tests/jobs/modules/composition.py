"""The services of docker-compose.yml, started as processes.

Commands, environment, ports and health checks are read from the file, so that a test of this is a test of the file.
Inside a container and out of it differ: where folders are mounted, the name of the database's host, and the ports.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import yaml

FILE = Path(__file__).resolve().parents[3] / "docker-compose.yml"
DATABASE, STORE = "postgres", "store"  # services that are no processes of ours
SECRETS = {"HGS_DATABASE_PASSWORD": "secret-1", "HGS_STORE_SECRET": "secret-2"}


class Composition:
    """The services of docker-compose.yml, with `folders` in the place of its volumes."""

    def __init__(self, folder: Path, database: tuple[str, int], port: int, store: str) -> None:
        """Keep the volumes under `folder`; `database`, `port` and `store` are where the services listen here."""
        text = substituted(FILE.read_text(), {"HGS_CAPTURE_FOLDER": str(folder / "captures"), **SECRETS})
        self.services: dict[str, dict[str, Any]] = yaml.safe_load(text)["services"]
        self.captures = folder / "captures"
        self._folder = folder
        self._database = database
        self._port = port
        self._store = store
        self._processes: list[subprocess.Popen[bytes]] = []

    def start(self, service: str, **more: str) -> subprocess.Popen[bytes]:
        """Start a service's command in its environment; `more` is added to that."""
        environment = {**os.environ, **self.environment(service), **more}
        command = [self._outside(word) for word in self.services[service]["command"]]
        with (self._folder / "log").open("ab") as log:
            process = subprocess.Popen(
                command, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=self._folder
            )
        self._processes.append(process)
        return process

    def healthy(self, service: str) -> bool:
        """Run the service's health check once, in its environment."""
        kind, *command = self.services[service]["healthcheck"]["test"]
        assert kind == "CMD"
        environment = {**os.environ, **self.environment(service)}
        checked = [self._outside(word) for word in command]
        done = subprocess.run(checked, env=environment, capture_output=True, check=False)
        return done.returncode == 0

    def environment(self, service: str) -> dict[str, str]:
        """Return the service's environment as a process outside of containers needs it."""
        mounts = {}
        for volume in self.services[service]["volumes"]:
            source, target = volume.split(":")[:2]
            mounts[target] = source if source.startswith("/") else str(self._folder / source)
        # Variables without a value are those of the shell, which all processes here have anyway.
        given = {name: value for name, value in self.services[service]["environment"].items() if value is not None}
        environment = {name: mounts.get(value, value) for name, value in given.items()}
        url = urlsplit(environment["HGS_DATABASE_URL"])
        assert url.hostname == DATABASE
        host, port = self._database
        environment["HGS_DATABASE_URL"] = url._replace(netloc=f"{url.username}:{url.password}@{host}:{port}").geturl()
        assert urlsplit(environment["AWS_ENDPOINT"]).hostname == STORE
        environment["AWS_ENDPOINT"] = self._store
        return environment

    def log(self) -> str:
        """Return the output of the processes."""
        return (self._folder / "log").read_text()

    def stop(self) -> None:
        """End all processes at once."""
        for process in self._processes:
            process.kill()
            process.wait()

    def _outside(self, word: str) -> str:
        programs = {"hgs": str(Path(sys.executable).parent / "hgs"), "python": sys.executable}
        return programs.get(word, re.sub(r"\b8000\b", str(self._port), word))


def substituted(text: str, variables: Mapping[str, str]) -> str:
    """Replace ${NAME:-DEFAULT} and ${NAME:?MESSAGE} as docker compose does.

    Raises:
        KeyError: a variable without a default is missing.
    """

    def value(match: re.Match[str]) -> str:
        given = variables.get(match[1], "")
        if not given and match[2] == "?":
            raise KeyError(match[1])
        return given or match[3]

    return re.sub(r"\$\{(\w+):([-?])([^}]*)\}", value, text)
