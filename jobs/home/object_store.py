"""The store that all machines share: a folder, or an object store such as S3."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import obstore
from obstore.exceptions import AlreadyExistsError, PreconditionError
from obstore.store import LocalStore, ObjectStore, from_url

from hgs_core.base.errors import InputError

__all__ = ["is_folder", "open_object_store", "require_conditional_puts"]

_AT_ONCE = 8  # puts of which one alone may succeed


def is_folder(url: str) -> bool:
    """Return whether the store is a folder of this machine."""
    return url.startswith("file://")


def open_object_store(url: str, *, once: bool = False) -> ObjectStore:
    """Open file:///FOLDER (made if missing), s3://BUCKET/PREFIX or any other URL that obstore knows.

    With `once`, a server that does not answer is not asked again.

    Raises:
        InputError: the environment's address of the server is none.
    """
    if is_folder(url):
        return LocalStore.from_url(url, mkdir=True)
    for name in ("AWS_ENDPOINT", "AWS_ENDPOINT_URL"):  # the library's own answer to such is a panic
        if (endpoint := os.environ.get(name)) and not re.match(r"https?://[^\s/]", endpoint):
            raise InputError(f"{name} {endpoint}", "is not the address of a server", "give https://HOST")
    # No options of the client's: they would take the place of what the environment says, all of it.
    return from_url(url, retry_config={"max_retries": 0} if once else None)


def require_conditional_puts(url: str) -> None:
    """Refuse a store in which several processes can replace the same object at once: some that speak S3 let them.

    Raises:
        InputError: it took none or more than one of several conditional puts of one object.
    """
    store, path = open_object_store(url), f"probe-{secrets.token_hex(8)}"

    def put(mode: Any) -> bool:
        try:
            obstore.put(store, path, secrets.token_bytes(16), mode=mode, use_multipart=False)
        except (AlreadyExistsError, PreconditionError, FileNotFoundError):
            return False
        return True

    try:
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            created = sum(pool.map(put, ["create"] * _AT_ONCE))
            mode = {"e_tag": obstore.head(store, path)["e_tag"]}
            replaced = sum(pool.map(put, [mode] * _AT_ONCE))
    finally:
        with contextlib.suppress(FileNotFoundError):
            obstore.delete(store, path)
    for header, taken in (("If-None-Match", created), ("If-Match", replaced)):
        if taken != 1:
            problem = f"took {taken} of {_AT_ONCE} puts of one object at once with {header}, and not one"
            raise InputError(f"HGS_STORE_URL {url}", problem, "use a store whose conditional puts are atomic, as S3's")
