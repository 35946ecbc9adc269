"""The environment variables of a stage: a process that decodes strangers' videos receives none of the worker's secrets.

A flaw in a video decoder would otherwise hand the database and the store to whoever may submit a capture.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
from collections.abc import Mapping
from pathlib import Path

from jobs.home.home import Home
from jobs.home.stage_settings import HELP, SHOW

__all__ = ["has_secrets", "keep_secrets", "stage_environment", "without_secrets"]

_SECRETS = (
    "AWS_",
    "AZURE_",
    "GOOGLE_",
    "PGPASS",
    "HGS_DATABASE_URL",
    "HGS_STORE_URL",
    "HGS_RUN_STATE",
    "HGS_WEBHOOK_",
    "HGS_KEY",
)
"""How the names of variables begin that give access to something, or lead to it."""

_SET_DUMPABLE = 4  # prctl(2)


def without_secrets(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the part of an environment for a process that only reads captures and works in folders."""
    return {name: value for name, value in environment.items() if not name.startswith(_SECRETS)}


def stage_environment(home: Home, stage: str, run: Path, environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the environment of a stage of a run."""
    whole = {**environment, **home.environment()}
    return whole if has_secrets(home, stage, run) else without_secrets(whole)


def has_secrets(home: Home, stage: str, run: Path) -> bool:
    """Return whether a stage reaches database and store.

    Only what publishes does; and where the state of runs lies in the store, what makes segments: it claims them and
    hands them over there.
    """
    exchanges = home.runs_in_store and (stage == HELP or (stage == "train" and _by_segment(run)))
    return stage in ("publish", SHOW) or exchanges


def keep_secrets() -> None:
    """Let no other process of this user, such as a stage, read the environment and the memory of this one; Linux."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_SET_DUMPABLE, 0, 0, 0, 0)


def _by_segment(run: Path) -> bool:
    """Return whether training may be by segments: it is not if run.json says so."""
    try:
        return json.loads((run / "run.json").read_bytes())["config"]["encode"]["by_segment"] is not False
    except (OSError, ValueError, KeyError, TypeError):
        return True
