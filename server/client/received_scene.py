"""A scene as far as a client has received it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.paged_manifest import PagedManifest
from server.client.playback import Throughput

__all__ = ["ReceivedScene", "StreamRefusedError"]


class StreamRefusedError(Exception):
    """The scene is refused for a reason that trying again does not cure."""


class ReceivedScene:
    """A scene, kept in memory as it comes; `arrived` is called whenever `manifest` or `have` may have changed."""

    def __init__(self, url: str, arrived: Callable[[], None] = lambda: None) -> None:
        """Begin with nothing of the scene at `url`."""
        self.have: dict[str, bytes] = {}
        self.missing: set[str] = set()
        self.complete = False  # but for what limits leave out
        self.payload = 0  # bytes of chunks that have come
        self.twice = 0  # bytes received twice
        self.wire = 0  # bytes of all messages that have come
        self.manifests = 0  # received manifests
        self.line = Throughput()
        self.arrived = arrived
        self.paged: PagedManifest | None = None
        self.url = url

    @property
    def manifest(self) -> Manifest | None:
        """The manifest, as far as its pages have come; another object whenever more of it has."""
        return None if self.paged is None else self.paged.manifest

    def become(self, document: Mapping[str, Any]) -> None:
        """Continue with a manifest or an index, given as plain JSON: the first, or the next of a growing scene.

        Raises:
            StreamRefusedError: it is that of another scene than before.
        """
        later = PagedManifest(document, f"manifest of {self.url}")
        if self.paged is None:
            self.paged = later
        elif self.paged.continued_by(later):
            self.paged.become(later)
        else:
            raise StreamRefusedError("another scene has taken its place")
        self.complete = False

    def take(self, name: str, data: bytes) -> None:
        """Keep a chunk, or read a page.

        Raises:
            StreamRefusedError: it is damaged.
        """
        if hashlib.sha256(data).hexdigest() != name:
            raise StreamRefusedError(f"chunk {name} has come damaged")
        if self.paged is None or not self.paged.lacks(name):
            self.have[name] = data
            return
        try:
            self.paged.add(name, data)
        except InputError as error:
            raise StreamRefusedError(str(error)) from error
