"""The longest lifetime of a link to a scene, for `POST /v1/links` and `hgs keys link` alike."""

from __future__ import annotations

__all__ = ["LONGEST_LINK_DAYS", "LONGEST_LINK_SECONDS"]

LONGEST_LINK_DAYS = 366
LONGEST_LINK_SECONDS = LONGEST_LINK_DAYS * 86400
