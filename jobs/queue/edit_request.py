"""The request for an edited copy of a published scene, checked before anything is written."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass

from jobs.queue.job_request import require_key, require_title

__all__ = ["EditRequest"]


@dataclass(frozen=True)
class EditRequest:
    """A published scene and the edit to make. The title defaults to the scene's."""

    scene: str
    document: bytes  # a file of docs/editing.md by strangers: read in the job's first stage alone
    title: str = ""
    key: str = ""  # idempotency key: the same request with the same key is the same job

    def __post_init__(self) -> None:
        """Check the title and the key.

        Raises:
            InputError: the title is too long or holds control characters, or the key is malformed.
        """
        require_title(self.title)
        require_key(self.key)

    @property
    def digest(self) -> str:
        """A hash of all that is asked for, but the key; no training has it."""
        asked = ["edit", self.scene, hashlib.sha256(self.document).hexdigest(), self.title]
        return hashlib.sha256(json.dumps(asked).encode()).hexdigest()
