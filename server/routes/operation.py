"""What whoever runs the server asks it: whether it lives, whether it is ready, what it counts, what it can do."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse
from starlette.concurrency import run_in_threadpool

from server.http.metrics import CONTENT_TYPE
from server.service import Service, ServiceDep

__all__ = ["router"]

router = APIRouter()

PROBE = "readiness-probe"  # an id that no scene has


@router.api_route("/healthz", methods=["GET", "HEAD"])
async def alive() -> dict[str, str]:
    """Answer as long as the process does."""
    return {"status": "ok"}


@router.api_route("/readyz", methods=["GET", "HEAD"])
async def ready(service: ServiceDep) -> Response:
    """Ask the database, the store and the workers; 503 where one of the first two is away or the server stops."""
    found = await run_in_threadpool(_looked_at, service)
    found["stopping"] = service.streams.ending or service.stopping.is_set()
    fit = found["database"] == found["store"] == "ok" and not found["stopping"]
    return JSONResponse(found, 200 if fit else 503, {"Cache-Control": "no-store"})


@router.api_route("/metrics", methods=["GET", "HEAD"])
async def metrics(service: ServiceDep) -> Response:
    """Tell the counters, and of the queue what can be told."""

    def told() -> bytes:
        found = _looked_at(service)
        if isinstance(found["jobs"], dict):
            for state, count in found["jobs"].items():
                service.metrics.jobs.labels(state).set(count)
        if found["workers"] is not None:
            service.metrics.workers.set(found["workers"])
        return service.metrics.text()

    return Response(await run_in_threadpool(told), media_type=CONTENT_TYPE, headers={"Cache-Control": "no-store"})


@router.api_route("/openapi.json", methods=["GET", "HEAD"])
async def openapi(request: Request) -> Response:
    """Describe the routes."""
    return JSONResponse(request.app.openapi())


def _looked_at(service: Service) -> dict[str, Any]:
    """Return how database and store answer, the jobs by state, and how many workers live."""
    found: dict[str, Any] = {"database": "ok", "store": "ok", "jobs": None, "workers": None}
    try:
        found["jobs"], found["workers"] = service.jobs.counts(), len(service.jobs.workers())
    except Exception:  # whatever it is, the server is not ready, and the cause is told where it is met
        found["database"] = "does not answer"
    try:
        service.artifacts.manifest(PROBE)
    except Exception:
        found["store"] = "does not answer"
    return found
