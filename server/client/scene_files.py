"""A scene's files over HTTP: those of a server of HGS, or of a folder on any web server (docs/static.md)."""

from __future__ import annotations

import asyncio
import http.client
import json
import urllib.error
import urllib.request
from dataclasses import dataclass, field
from typing import Any, Self
from urllib.parse import urljoin, urlsplit

from hgs_core.base.errors import InputError
from hgs_core.codec.format.paged_manifest import read_index
from hgs_core.codec.format.paging import INDEX_FORMAT
from server.client.received_scene import StreamRefusedError

__all__ = ["AwayError", "SceneFiles"]

DOWNLOAD_SILENCE = 10.0  # seconds without a byte, after which a download is given up
_MAY_PASS = frozenset({408, 429})
_GZIP = b"\x1f\x8b"


class AwayError(Exception):
    """The server does not answer, or answers something else; another try may help."""


@dataclass
class SceneFiles:
    """The addresses of a scene's files, and how to get them. `opens` is a query, such as `?link=…`, or ""."""

    first: str  # an index or a manifest
    whole: str  # the whole manifest, of an index in pages
    opens: str = ""
    key: str = ""  # sent as Authorization: Bearer
    _tag: str | None = field(default=None, init=False)  # ETag of the first answer

    @classmethod
    def beside(cls, stream: str, key: str = "") -> Self:
        """Return those of a scene by the address of its stream, `ws://host/v1/scenes/{scene}/stream?link=…`."""
        base = "http" + stream.removeprefix("ws").partition("?")[0]
        query = urlsplit(stream).query
        return cls(urljoin(base, "index.hgs"), urljoin(base, "manifest"), f"?{query}" if query else "", key)

    @classmethod
    def at(cls, url: str, key: str = "") -> Self:
        """Return those of a folder (`…/`), of its `manifest.json` or of its `index.hgs`."""
        first = urljoin(url, "manifest.json") if urlsplit(url).path.endswith("/") else url
        return cls(first, urljoin(first, "manifest.json"), key=key)

    async def manifest(self) -> dict[str, Any] | None:
        """Return the whole manifest as plain JSON, or None if it is as it was.

        Raises:
            StreamRefusedError: there is no such scene, or not for who asks.
            AwayError: no manifest has come.
        """
        found = await self._get(self.first + self.opens, self._tag)
        if found is None:
            return None
        try:
            packed = found[0].startswith(_GZIP)
            document = read_index(found[0], self.first) if packed else dict(json.loads(found[0]))
            if document.get("format") == INDEX_FORMAT:
                whole = await self._get(self.whole + self.opens)
                document = dict(json.loads(whole[0] if whole else b""))
        except (ValueError, TypeError, InputError) as error:
            raise AwayError(f"{self.first}: something else than a manifest has come") from error
        self._tag = found[1]
        return document

    async def chunk(self, name: str) -> bytes | None:
        """Return a chunk's bytes; None if the server says that it has none.

        Raises:
            StreamRefusedError: the key or link is no longer valid.
            AwayError: it has not come.
        """
        try:
            found = await self._get(urljoin(self.first, f"chunks/{name}") + self.opens)
        except _NothingThereError:
            return None
        return None if found is None else found[0]

    async def _get(self, url: str, tag: str | None = None) -> tuple[bytes, str | None] | None:
        return await asyncio.to_thread(self._fetched, url, tag)

    def _fetched(self, url: str, tag: str | None) -> tuple[bytes, str | None] | None:
        """Return a body and its ETag, None where the tag is that one still."""
        request = urllib.request.Request(url)
        if self.key:
            request.add_unredirected_header("Authorization", f"Bearer {self.key}")  # sent to this server alone
        if tag:
            request.add_header("If-None-Match", tag)
        try:
            with urllib.request.urlopen(request, timeout=DOWNLOAD_SILENCE) as answer:
                return answer.read(), answer.headers.get("ETag")
        except urllib.error.HTTPError as error:
            with error:
                if error.code == 304:
                    return None
                raise _refusal(error, url) from error
        except (OSError, http.client.HTTPException) as error:
            raise AwayError(f"{url}: {error}") from error


class _NothingThereError(StreamRefusedError):
    """The server says that it has no such file."""


def _refusal(error: urllib.error.HTTPError, url: str) -> StreamRefusedError | AwayError:
    """Return the meaning of a status of 400 or more: final, or worth another try."""
    try:
        told = json.loads(error.read(1 << 16))
    except (ValueError, OSError, http.client.HTTPException):
        told = None
    problem = told if isinstance(told, dict) and "code" in told else {}  # else it is not the server that has answered
    detail = str(problem.get("detail", f"{url.partition('?')[0]}: the server answered {error.code}"))
    if error.code in (401, 403):
        return StreamRefusedError(f"{detail}; set HGS_KEY to a key of that server, or give an address with ?link=")
    if error.code in (404, 410) and (problem or "/v1/" not in url):
        return _NothingThereError(detail)
    if problem and error.code < 500 and error.code not in _MAY_PASS:
        return StreamRefusedError(detail)
    return AwayError(detail)
