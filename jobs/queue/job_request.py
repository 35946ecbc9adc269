"""The request for a job, checked before anything is written."""

from __future__ import annotations

import hashlib
import json
import math
import re
import secrets
import unicodedata
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import require_storable
from hgs_core.runs.given_files import GivenFiles
from jobs.queue.enqueue import MAX_PRIORITY
from jobs.records.job_filter import checked_labels
from jobs.webhooks.webhook_rules import WebhookRules

if TYPE_CHECKING:
    from hgs_core.runs.run_config import RunConfig

__all__ = [
    "MAX_PATH",
    "MAX_TIME_LIMIT",
    "MAX_TITLE",
    "JobRequest",
    "one_line",
    "readable_id",
    "require_key",
    "require_title",
]

MAX_TITLE = 200  # characters
MAX_PATH = 4096  # characters, as Linux
MAX_TIME_LIMIT = 366 * 86400.0  # seconds
_KEY = re.compile(r"[!-~]{1,255}")


@dataclass(frozen=True)
class JobRequest:
    """A capture to train with a config. The title is for people; it defaults to the capture's name."""

    capture: Path
    config: RunConfig
    title: str = ""
    given: GivenFiles = field(default_factory=GivenFiles)  # a sound by its absolute path
    labels: tuple[str, ...] = ()  # search terms for people
    priority: int = 0  # -100 to 100: the highest are taken first
    time_limit: float = 0.0  # seconds that an attempt may take once a worker has taken it; 0: any
    webhook: str = ""  # a URL that is told when the job ends
    key: str = ""  # idempotency key: the same request with the same key is the same job

    def __post_init__(self) -> None:
        """Check the texts shown to people.

        Raises:
            InputError: the title is too long or holds control characters, a path is no text, a label or the key is
                malformed, a number is out of its range, or the webhook is not allowed.
        """
        require_title(self.title)
        for name, path in (("capture", str(self.capture)), *self.given.to_json().items()):
            require_storable(name, path, MAX_PATH)
        object.__setattr__(self, "labels", checked_labels(self.labels))
        if not -MAX_PRIORITY <= self.priority <= MAX_PRIORITY:
            raise InputError.of_field(
                "priority", f"{self.priority} is out of range", f"give -{MAX_PRIORITY} to {MAX_PRIORITY}"
            )
        if not (self.time_limit == 0 or 1 <= self.time_limit <= MAX_TIME_LIMIT) or math.isnan(self.time_limit):
            raise InputError.of_field(
                "time_limit", f"{self.time_limit:g} s is out of range", "give 1 s to 366 days, or 0 for none"
            )
        if self.webhook:
            WebhookRules.configured().checked(self.webhook)
        require_key(self.key)

    @property
    def digest(self) -> str:
        """A hash of all that is asked for, but the key."""
        asked = [
            str(self.capture),
            self.config.to_json(),
            self.title,
            str(self.given.masks or ""),
            self.labels,
            self.priority,
            self.time_limit,
            self.webhook,
        ]
        # Keys that were given before there were these still hold.
        given = self.given.to_json()
        asked += [given["audio"]] if "audio" in given else []
        asked += [f"{name} {given[name]}" for name in ("depth", "mesh") if name in given]
        return hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()


def require_title(title: str) -> None:
    """Reject a title that no list of jobs can show.

    Raises:
        InputError: it is too long or holds control characters.
    """
    require_storable("title", title, MAX_TITLE)
    if one_line(title) != title:
        raise InputError.of_field("title", f"{title!a} holds control characters", "give one line of text")


def require_key(key: str) -> None:
    """Reject a malformed idempotency key; "" is none.

    Raises:
        InputError: it is too long, or holds spaces or other than ASCII characters.
    """
    if key and not _KEY.fullmatch(key):
        problem = f"{key[:80]!a} is no idempotency key"
        raise InputError.of_field("key", problem, "give 1 to 255 visible ASCII characters")


def one_line(text: str) -> str:
    """Return the text with spaces for control characters and the ends of lines and paragraphs."""
    return "".join(" " if unicodedata.category(one) in ("Cc", "Zl", "Zp") else one for one in text)


def readable_id(title: str, otherwise: str) -> str:
    """Return a unique id that is safe in URLs and file names, such as "studio-1f9c03ab", or that of `otherwise`."""
    slug = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")[:40].strip("-")
    return f"{slug or otherwise}-{secrets.token_hex(4)}"
