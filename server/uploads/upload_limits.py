"""Limits on uploads."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Self

from hgs_core.base.errors import InputError
from server.http.problems import ProblemError

__all__ = ["UploadLimits", "bytes_for_people"]

SETTING = "HGS_UPLOADS"

GB = 1000**3
_UNITS = {"": 1, "k": 1000, "m": 1000**2, "g": GB, "t": 1000 * GB}
_NUMBER = re.compile(r"([0-9]{1,12}(?:\.[0-9]{1,6})?)([kmgt]?)b?", re.IGNORECASE)


@dataclass(frozen=True)
class UploadLimits:
    """Limits in bytes, except for `files`, `open`, `client` and `hours`."""

    quota: int = 500 * GB  # all uploads, including those that have become captures; 0: uploads are disabled
    upload: int = 200 * GB  # one upload
    file: int = 100 * GB  # one file
    files: int = 20_000  # files per upload
    open: int = 16  # unfinished uploads
    client: int = 4  # unfinished uploads per key, or per address without keys
    share: int | None = None  # the quota of one key, or of one address without keys; None: no other
    free: int = 10 * GB  # disk space that uploads leave free
    hours: float = 48.0  # idle time after which an unfinished upload is deleted

    @classmethod
    def configured(cls, given: str = "", environment: Mapping[str, str] = os.environ) -> Self:
        """Parse `given`, or else `HGS_UPLOADS`, such as "quota=2T,file=20G,hours=12"; "off" disables uploads.

        Raises:
            InputError: an unknown name, or a value out of range.
        """
        where, text = ("--uploads", given) if given else (SETTING, environment.get(SETTING, ""))
        if text.strip() == "off":
            return cls(quota=0)
        known = [field.name for field in fields(cls)]
        values: dict[str, float] = {}
        for part in filter(None, (part.strip() for part in text.split(","))):
            name, _, value = part.partition("=")
            number = _NUMBER.fullmatch(value)
            if name not in known or number is None or name in values:
                cure = f"give {', '.join(known)} as in quota=2T,hours=12, or off"
                raise InputError(where, f"{part[:80]!r} is not a limit", cure)
            amount = float(number[1]) * _UNITS[number[2].lower()]
            least = 0 if name in ("quota", "free") else 0.01 if name == "hours" else 1
            if not least <= amount <= 2**53:
                raise InputError(where, f"{part[:80]!r} is out of range", f"give {least} or more")
            values[name] = amount if name == "hours" else math.floor(amount)
        return cls(**values)  # type: ignore[arg-type]

    def check_upload(self, files: int, size: int) -> None:
        """Reject an upload that is too large by itself.

        Raises:
            ProblemError: 403 uploads are disabled; 413 too many files or bytes, with the limit and the cure.
        """
        if self.quota == 0:
            detail = "uploads are disabled on this server; the operator can enable them: hgs serve --uploads quota=500G"
            raise ProblemError(403, "uploads-off", detail)
        if files > self.files:
            raise _too_large("files", f"{files:,} files; one upload may have {self.files:,}", f"files={files}")
        if size > self.upload:
            limit = f"{bytes_for_people(size)}; one upload may have {bytes_for_people(self.upload)}"
            raise _too_large("bytes", limit, f"upload={_rounded_up(size)}")

    def check_quota(self, size: int, held: int, own: int) -> None:
        """Reject an upload for which its client, with `own` bytes there, or all, with `held`, have no room left.

        Raises:
            ProblemError: 507.
        """
        share = self.quota if self.share is None else self.share
        for most, there, whose, setting in (
            (self.quota, held, "uploads", "quota"),
            (share, own, "uploads of one key or address", "share"),
        ):
            if there + size > most:
                detail = (
                    f"{whose} may take {bytes_for_people(most)} in total (--uploads {setting}), of which "
                    f"{bytes_for_people(max(most - there, 0))} are left, and this one has {bytes_for_people(size)}; "
                    "delete uploaded captures that are no longer needed"
                )
                raise ProblemError(507, "upload-quota", detail, field="bytes")

    def check_file(self, path: str, size: int) -> None:
        """Reject a file that is too large by itself.

        Raises:
            ProblemError: 413.
        """
        if size > self.file:
            limit = f"{path[:80]!r} has {bytes_for_people(size)}; one file may have {bytes_for_people(self.file)}"
            raise _too_large("size", limit, f"file={_rounded_up(size)}")


def bytes_for_people(size: float) -> str:
    """Return "812 bytes", "1.3 GB", in powers of 1000."""
    for unit, scale in (("TB", 1000 * GB), ("GB", GB), ("MB", 1000**2), ("kB", 1000)):
        if size >= scale:
            return f"{size / scale:.1f} {unit}"
    return f"{size:.0f} bytes"


def _rounded_up(size: int) -> str:
    return f"{math.ceil(size / GB)}G"


def _too_large(field: str, limit: str, setting: str) -> ProblemError:
    cure = f"send less, or ask the server's operator to start it with --uploads {setting}"
    return ProblemError(413, "upload-too-large", f"{limit}; {cure}", field=field)
