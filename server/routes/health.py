"""`/v1/health`: whether the server answers, and which protocol it speaks."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from typing import Any

from fastapi import APIRouter

from server.protocol import PROTOCOL_VERSION

__all__ = ["router", "software_version"]

router = APIRouter()


def software_version() -> str:
    """Return the installed version of HGS; "0+unknown" in a checkout that is not installed."""
    try:
        return version("hgs")
    except PackageNotFoundError:
        return "0+unknown"


@router.api_route("/v1/health", methods=["GET", "HEAD"])
async def health() -> dict[str, Any]:
    """Answer without touching the database or the store."""
    return {"status": "ok", "version": software_version(), "protocol": PROTOCOL_VERSION}
