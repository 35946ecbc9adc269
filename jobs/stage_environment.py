"""What a stage is told by environment variables: what decodes strangers' videos gets none of the worker's secrets.

A flaw in a video decoder would otherwise hand the database and the store to whoever may submit a capture.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path

from jobs.home import Home
from jobs.stages import HELP

__all__ = ["stage_environment", "without_secrets"]

_SECRETS = (
    "AWS_", "AZURE_", "GOOGLE_", "PGPASS",
    "HGS_DATABASE_URL", "HGS_STORE_URL", "HGS_RUN_STATE", "HGS_WEBHOOK_", "HGS_KEY",
)  # fmt: skip
"""How the names of variables begin that give access to something, or lead to it."""


def without_secrets(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return what a process that only reads captures and works in folders needs of an environment."""
    return {name: value for name, value in environment.items() if not name.startswith(_SECRETS)}


def stage_environment(home: Home, stage: str, run: Path, environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the environment of a stage of a run.

    Only what publishes has database and store: the stage of this name, and training whose segments are shown as they
    are made.
    """
    whole = {**environment, **home.environment()}
    return whole if stage in ("publish", HELP) or (stage == "train" and _by_segment(run)) else without_secrets(whole)


def _by_segment(run: Path) -> bool:
    """Return whether training may publish: it does not if run.json says so."""
    try:
        return json.loads((run / "run.json").read_bytes())["config"]["encode"]["by_segment"] is not False
    except (OSError, ValueError, KeyError, TypeError):
        return True
