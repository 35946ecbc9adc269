"""A scene under a prefix of an S3 bucket, for browsers and CDNs (docs/static.md)."""

from __future__ import annotations

import hashlib
import re
from collections import deque
from collections.abc import Collection, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

import obstore
from obstore.exceptions import BaseError

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, silent
from hgs_core.codec.format.scene_folder import CHUNKS
from jobs.home.object_store import open_object_store
from jobs.home.passing_faults import one_line
from server.http.media_types import MEDIA_TYPES, OCTET_STREAM
from server.publishing.static_folder import PLAYER, StaticFile, Transfer, publish_static

if TYPE_CHECKING:
    from obstore import ObjectMeta

__all__ = ["publish_to_bucket"]

_URL = re.compile(r"s3://[A-Za-z0-9][A-Za-z0-9._-]+(?:/(?!\.{1,2}(?:/|$))[A-Za-z0-9!_.*'()-]+)*/?")
_AT_ONCE = 8  # uploads: round trips to a store take longer than most chunks
_KEEP = "public, max-age=31536000, immutable"  # chunks, named by hashes of their content
_ASK = "no-cache"
_STATUS = re.compile(r"non-2xx status code: (\d{3})")
_HOST = re.compile(r"https?://[^/\s]+")
_CODE = re.compile(r"<Code>([^<]{1,60})</Code>")


def publish_to_bucket(
    run: Path, url: str, *, player: Path | None, replace: bool = False, progress: ProgressCallback = silent
) -> Transfer:
    """Put the scene of a finished run under `url`, s3://BUCKET or s3://BUCKET/PREFIX; see `publish_to_folder`.

    Objects with the same content are not sent again. Endpoint, region and credentials come from the environment,
    as for the service's store; temporary faults are retried.

    Raises:
        InputError: as for a folder; or `url` is malformed, or the bucket is missing, forbidden or unreachable.
    """
    if not _URL.fullmatch(url):
        cure = "give s3://BUCKET/PREFIX, the prefix of letters, digits, -, _, . and /"
        raise InputError(url, "is not the URL of a bucket", cure)
    try:
        return publish_static(run, _WebBucket(url.rstrip("/")), player, replace, progress)
    except (BaseError, OSError) as error:
        raise InputError(url, *_told(error)) from error


class _WebBucket:
    """A `StaticTarget` in an object store."""

    kind = "prefix"
    takes_codings = True

    def __init__(self, url: str) -> None:
        self._url = url
        self._store = open_object_store(url)
        here = obstore.list_with_delimiter(self._store)
        self._names = {*here["common_prefixes"], *(item["path"] for item in here["objects"])} - {""}
        self._there: dict[str, ObjectMeta] = {item["path"]: item for item in here["objects"]}
        for folder in {CHUNKS, PLAYER} & self._names:
            for page in obstore.list(self._store, prefix=folder):
                self._there.update({item["path"]: item for item in page})

    def __str__(self) -> str:
        return self._url

    def names(self) -> list[str]:
        return sorted(self._names)

    def read(self, name: str) -> bytes:
        return bytes(obstore.get(self._store, name).bytes())

    def write(self, files: Iterable[StaticFile]) -> Transfer:
        done = Transfer()
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            under_way: deque[Future[Transfer]] = deque()
            for file in files:
                if len(under_way) == _AT_ONCE:
                    done += under_way.popleft().result()
                under_way.append(pool.submit(self._put, file))
            for one in under_way:
                done += one.result()
        return done

    def remove(self, name: str) -> None:
        if name in self._there:
            obstore.delete(self._store, name)

    def remove_other_chunks(self, wanted: Collection[str]) -> None:
        chunks = {path for path in self._there if path.startswith(f"{CHUNKS}/")}
        if left := sorted(chunks - {f"{CHUNKS}/{name}" for name in wanted}):
            obstore.delete(self._store, left)

    def _put(self, file: StaticFile) -> Transfer:
        if self._holds(file):
            return Transfer(kept=1)
        chunk = file.name.startswith(f"{CHUNKS}/")
        attributes = {
            "Content-Type": MEDIA_TYPES.get(PurePosixPath(file.name).suffix, OCTET_STREAM),
            "Cache-Control": _KEEP if chunk else _ASK,
        }
        if file.coding:
            attributes["Content-Encoding"] = file.coding
        obstore.put(self._store, file.name, file.data, attributes=attributes, use_multipart=False)
        return Transfer(1, len(file.data))

    def _holds(self, file: StaticFile) -> bool:
        there = self._there.get(file.name)
        if there is None or there["size"] != len(file.data):
            return False
        md5 = hashlib.md5(file.data, usedforsecurity=False).hexdigest()
        # Multipart uploads and objects encrypted with the user's key have another ETag.
        return (there["e_tag"] or "").strip('"') == md5 or self.read(file.name) == file.data


def _told(error: BaseException) -> tuple[str, str]:
    """Return a store's error in one line, and the cure."""
    text = str(error)
    status, code = _STATUS.search(text), _CODE.search(text)
    said = f": {code[1]}" if code is not None else ""
    again = "repeat the command, which continues where it stopped"
    if isinstance(error, OSError) and error.errno is not None:
        return f"cannot be written ({error})", again
    if "169.254.169.254" in text:  # address of cloud credentials, used if none are set
        return "no credentials were found", "set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"
    if code is not None and code[1] == "NoSuchBucket":
        return "there is no such bucket", "create it, or correct the address or AWS_ENDPOINT"
    if status is not None and status[1] in ("401", "403"):
        rights = "AWS_SECRET_ACCESS_KEY, with the right to list, get, put and delete objects here"
        return f"the store refuses access ({status[1]}{said})", f"set AWS_ACCESS_KEY_ID and {rights}"
    if "builder error" in text:
        return "the store's address is not https", "give https://HOST as AWS_ENDPOINT, or set AWS_ALLOW_HTTP=true"
    if "incorrectly configured region" in text:
        return "the bucket is in another region", "set AWS_REGION"
    if status is not None:
        return f"the store failed ({status[1]}{said})", again
    host = _HOST.search(text)
    cause = one_line(text.partition("\n\n")[0].rpartition(" - ")[2])
    return f"the store {'' if host is None else f'at {host[0]} '}failed ({cause})", again
