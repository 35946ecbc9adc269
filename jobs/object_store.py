"""Opens the place of what all machines share: a folder, or an object store such as S3."""

from __future__ import annotations

from obstore.store import LocalStore, ObjectStore, from_url

__all__ = ["is_folder", "open_object_store"]


def is_folder(url: str) -> bool:
    """Return whether the store is a folder of this machine."""
    return url.startswith("file://")


def open_object_store(url: str, *, once: bool = False) -> ObjectStore:
    """Open file:///FOLDER (made if missing), s3://BUCKET/PREFIX or any other URL that obstore knows.

    With `once`, a server that does not answer is not asked again.
    """
    if is_folder(url):
        return LocalStore.from_url(url, mkdir=True)
    # No options of the client's: they would take the place of what the environment says, all of it.
    return from_url(url, retry_config={"max_retries": 0} if once else None)
