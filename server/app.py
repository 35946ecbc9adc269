"""The ASGI application: `create_app` assembles the service and its routes."""

from __future__ import annotations

import asyncio
import dataclasses
import functools
import logging
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from pathlib import Path

from fastapi import FastAPI
from fastapi.telemetry import TelemetryConfig
from starlette.middleware.cors import CORSMiddleware

from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.runs.stored_captures import StoredCaptures
from server.access.allowed_hosts import AllowedHosts, HostCheck
from server.access.door import AccessControl
from server.access.origins import OriginPolicy
from server.access.request_rate import RequestRate
from server.access.visitors import Access, Asking
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_readers import CaptureReaders
from server.captures.run_creation import LimitedCreation
from server.http.metrics import Metrics
from server.http.problems import install_problem_handlers
from server.http.request_log import RequestLog
from server.http.security_headers import SecurityHeaders
from server.http.site_root import SiteRoot
from server.http.stopped_requests import StoppedRequests
from server.parts import Artifacts, Jobs
from server.routes import (
    capture_checks,
    chunks,
    edits,
    health,
    job_runs,
    jobs,
    links,
    operation,
    scenes,
    session,
    stream,
    submissions,
    upload_files,
    workers,
)
from server.routes import captures as capture_routes
from server.routes import uploads as upload_routes
from server.routes.api_description import describe_api
from server.routes.viewer_pages import VIEWER, viewer_router
from server.scenes.chunk_cache import ChunkCache
from server.service import Service
from server.stream.admission import OpenStreams, StreamAdmission
from server.uploads.upload_limits import UploadLimits
from server.uploads.uploads import Uploads

__all__ = ["create_app"]

SWEEP_SECONDS = 600.0

# FastAPI would give every request's address, and with it links' tokens, to any tracer that the process has, and send
# it where variables of the environment say. Metrics are at /metrics.
NO_TELEMETRY: TelemetryConfig = {"tracing": False, "metrics": False, "logs": False, "auto_configure": False}

log = logging.getLogger("hgs.server")


def create_app(
    home: Home,
    *,
    captures: CaptureFolders | None = None,
    uploads: UploadLimits | None = None,
    origins: Iterable[str] = (),
    hosts: AllowedHosts | None = None,
    job_client: Jobs | None = None,
    artifacts: Artifacts | None = None,
    access: Access | None = None,
    max_streams: int | None = None,
    requests_per_second: float | None = None,
    viewer: Path = VIEWER,
    root: str = "",
) -> FastAPI:
    """Return the application that serves `home`; create the home and its tables if they are missing.

    `captures` are the folders that jobs may read, `uploads` how much clients may send, `origins` the pages of other
    hosts that may read scenes and chunks (`*` for all), `hosts` the names that the server answers to, by default
    localhost alone, `access` who is let in, by default everybody, `max_streams` how many streams are open at once, by
    default as many as come, `requests_per_second` how many requests one client may make, by default any number, `root`
    the path under which a proxy passes requests on, by default none. The queue, the store and the folder of the built
    viewer can be replaced, as tests do.
    """
    store = artifacts or open_store(home)
    received = Uploads(home.folder / "uploads", uploads, StoredCaptures(home) if home.runs_in_store else None)
    metrics = Metrics()
    readers = CaptureReaders(home)
    service = Service(
        home=home,
        jobs=job_client or JobClient(home, LimitedCreation(readers).create_run),
        artifacts=store,
        chunks=ChunkCache(store.chunk),
        captures=dataclasses.replace(
            captures or CaptureFolders.configured(home.folder), uploaded=received.captures.resolve()
        ),
        uploads=received,
        access=access or Access(None, Asking.NEVER),
        readers=readers,
        metrics=metrics,
        streams=OpenStreams(max_streams, lambda: metrics.lag),
        origins=OriginPolicy(frozenset(origins)),
    )

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        sweeping = asyncio.create_task(_sweep(service))
        lag = asyncio.create_task(metrics.watch_lag())
        yield
        lag.cancel()
        service.stopping.set()
        sweeping.cancel()
        readers.close()
        await service.submissions.close()
        for pool in (service.capture_list, service.camera_pictures, service.long_work, service.file_work):
            pool.close()
        await service.capture_checks.close()
        received.close()
        service.jobs.close()

    app = FastAPI(title="HGS", lifespan=lifespan, openapi_url=None, redirect_slashes=False, telemetry=NO_TELEMETRY)
    app.state.service, app.state.api = service, []
    install_problem_handlers(app)
    app.add_middleware(StreamAdmission, streams=service.streams, refused=metrics.refused.inc)
    if requests_per_second is not None:
        app.add_middleware(RequestRate, rate=requests_per_second)
    app.add_middleware(AccessControl, access=service.access, chunks_of=service.catalogue.chunk_ids)
    if service.origins.readers:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=sorted(service.origins.readers),
            allow_methods=["GET", "HEAD"],
            allow_headers=["Authorization", "If-None-Match", "If-Range", "Range"],
            expose_headers=["Content-Range", "ETag"],
            max_age=3600,
        )
    app.add_middleware(HostCheck, hosts=hosts or AllowedHosts())
    app.add_middleware(StoppedRequests, stopping=service.stopping)
    app.add_middleware(SecurityHeaders)
    app.add_middleware(RequestLog, metrics=metrics)
    app.add_middleware(SiteRoot, root=root)
    for module in (
        health,
        operation,
        session,
        links,
        capture_routes,
        capture_checks,
        upload_routes,
        upload_files,
        jobs,
        submissions,
        job_runs,
        workers,
        scenes,
        edits,
        chunks,
        stream,
    ):
        app.include_router(module.router)
        app.state.api += module.router.routes
    app.include_router(viewer_router(viewer))
    app.openapi = functools.cache(lambda: describe_api(app))  # type: ignore[method-assign]
    return app


async def _sweep(service: Service) -> None:
    """Delete abandoned uploads from time to time."""
    uploads = service.uploads
    while True:
        try:
            await service.long_work.run(uploads.sweep)
        except Exception as error:  # a later sweep may succeed
            log.warning("cannot delete abandoned uploads: %r", error)
        await asyncio.sleep(SWEEP_SECONDS)
