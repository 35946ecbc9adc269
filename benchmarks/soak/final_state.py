"""The state of a service after a soak: everything that its promises can be compared with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

__all__ = ["FinalJob", "FinalScene", "FinalState"]


@dataclass(frozen=True)
class FinalJob:
    """A job of the list."""

    state: str
    error: str = ""
    waiting: str = ""
    labels: Sequence[str] = ()  # idempotency keys of its submission


@dataclass(frozen=True)
class FinalScene:
    """A published scene."""

    title: str
    manifest: str  # SHA-256
    missing: Sequence[str] = ()  # chunks that the store lacks
    damaged: Sequence[str] = ()


@dataclass(frozen=True)
class FinalState:
    """Jobs, scenes and uploaded captures by their ids, and the rest of a service that has settled."""

    jobs: Mapping[str, FinalJob] = field(default_factory=dict)
    scenes: Mapping[str, FinalScene] = field(default_factory=dict)
    captures: Mapping[str, Mapping[str, str]] = field(default_factory=dict)  # SHA-256 by file
    keys: Mapping[str, int] = field(default_factory=dict)  # status of a request with each
    stages: Sequence[str] = ()  # command lines of processes that still work on runs
