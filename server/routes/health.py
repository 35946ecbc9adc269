"""`/v1/health`: status of the server and version of its protocol."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from hgs_core.base.version import software_version
from server.protocol.messages import PROTOCOL_VERSION

__all__ = ["router"]

router = APIRouter()


@router.api_route("/v1/health", methods=["GET", "HEAD"])
async def health() -> dict[str, Any]:
    """Respond without access to the database or the store."""
    return {"status": "ok", "version": software_version(), "protocol": PROTOCOL_VERSION}
