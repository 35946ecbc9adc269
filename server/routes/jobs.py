"""`/v1/jobs`: list, describe, follow, cancel, retry and delete jobs; submission is in `submissions.py`."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from jobs.queue.client import JobConflictError
from jobs.records.job import JobState
from server.http.conditional import respond_json
from server.http.problems import ProblemError
from server.job_views.job_description import describe_job, revision
from server.job_views.job_followers import job_events
from server.job_views.job_query import JobQuery, cursor
from server.service import ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/jobs")


@router.api_route("", methods=["GET", "HEAD"])
def list_jobs(request: Request, service: ServiceDep) -> Response:
    """List the jobs: running, waiting, finished, each newest first."""
    query = JobQuery.read(request.query_params.multi_items())
    jobs = service.jobs.list(query.limit + 1, query.state, query.after, query.wanted)
    page = jobs[: query.limit]
    more = cursor(page[-1]) if len(jobs) > len(page) else None
    return respond_json(request, {"jobs": [describe_job(job) for job in page], "next": more})


@router.api_route("/{job_id}", methods=["GET", "HEAD"])
def get_job(job_id: str, service: ServiceDep) -> dict[str, Any]:
    """Describe one job."""
    return describe_job(service.known_job(job_id))


@router.get("/{job_id}/events")
async def events(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Follow one job until it is finished."""
    job = await run_in_threadpool(service.known_job, job_id)
    if job.state.finished and request.headers.get("Last-Event-ID") == revision(job):
        return Response(status_code=204)
    stream = job_events(service.followers, job)
    return StreamingResponse(stream, media_type="text/event-stream", headers={"Cache-Control": "no-store"})


@router.post("/{job_id}/cancel", status_code=202)
def cancel(request: Request, job_id: str, service: ServiceDep) -> dict[str, Any]:
    """Cancel a job."""
    service.origins.require_same_site(request)
    service.known_job(job_id)
    job = service.jobs.cancel(job_id)
    if job.state is not JobState.CANCELLED:
        raise ProblemError(409, "job-finished", f"job {job_id}: {job.state.value}; a finished job cannot be cancelled")
    return describe_job(job)


@router.post("/{job_id}/retry", status_code=202)
def retry(request: Request, job_id: str, service: ServiceDep) -> dict[str, Any]:
    """Queue a failed or cancelled job again; it continues from its last checkpoint."""
    service.origins.require_same_site(request)
    service.known_job(job_id)
    try:
        return describe_job(service.jobs.retry(job_id))
    except JobConflictError as error:
        raise ProblemError(409, "job-not-retriable", str(error)) from error


@router.delete("/{job_id}", status_code=204)
async def delete(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Delete a finished job and its run folder; its scene stays published."""
    service.origins.require_same_site(request)
    await run_in_threadpool(service.known_job, job_id)
    try:
        await service.long_work.run(service.jobs.delete, job_id)
    except JobConflictError as error:
        raise ProblemError(409, "job-not-finished", str(error)) from error
    return Response(status_code=204)
