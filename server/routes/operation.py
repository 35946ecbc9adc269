"""Routes for operators: liveness, readiness, metrics and the OpenAPI description."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse
from starlette.concurrency import run_in_threadpool

from server.http.metrics import CONTENT_TYPE
from server.service import Service, ServiceDep

__all__ = ["router"]

router = APIRouter()

PROBE = "readiness-probe"  # not the id of any scene


@router.api_route("/healthz", methods=["GET", "HEAD"])
async def alive() -> dict[str, str]:
    """Respond while the process is alive."""
    return {"status": "ok"}


@router.api_route("/readyz", methods=["GET", "HEAD"])
async def ready(service: ServiceDep) -> Response:
    """Report the state of database, store and workers; 503 if one of the first two is down or the server stops."""
    found = await run_in_threadpool(_looked_at, service)
    found["stopping"] = service.streams.ending or service.stopping.is_set()
    fit = found["database"] == found["store"] == "ok" and not found["stopping"]
    return JSONResponse(found, 200 if fit else 503, {"Cache-Control": "no-store"})


@router.api_route("/metrics", methods=["GET", "HEAD"])
async def metrics(service: ServiceDep) -> Response:
    """Return the metrics, including those of the queue."""

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
    """Return the state of database and store, the number of jobs by state, and the number of live workers."""
    found: dict[str, Any] = {"database": "ok", "store": "ok", "jobs": None, "workers": None}
    try:
        found["jobs"], found["workers"] = service.jobs.counts(), len(service.jobs.workers())
    except Exception:  # any error means not ready; its cause is logged elsewhere
        found["database"] = "does not answer"
    try:
        service.artifacts.manifest(PROBE)
    except Exception:
        found["store"] = "does not answer"
    return found
