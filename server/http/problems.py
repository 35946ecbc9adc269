"""Problem documents (RFC 9457), the form of every error response."""

from __future__ import annotations

import errno
import json
import logging
from http import HTTPStatus
from typing import Any
from urllib.parse import quote

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from obstore.exceptions import BaseError
from sqlalchemy.exc import OperationalError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, HTTPConnection

from hgs_core.base.errors import InputError
from server.http.allowed_methods import allowed_methods
from server.http.problem_error import ProblemError
from server.http.site_root import site_root

__all__ = ["PROBLEM_JSON", "ProblemError", "install_problem_handlers", "problem_document", "problem_response"]

log = logging.getLogger("hgs.server")


PROBLEM_JSON = "application/problem+json"

_OF_ROUTES = (HTTPStatus.NOT_FOUND, HTTPStatus.METHOD_NOT_ALLOWED)
_LONGEST_PATH = 300  # characters repeated in a response


def install_problem_handlers(app: FastAPI) -> None:
    """Answer every uncaught exception of a route with a problem document."""

    @app.exception_handler(ProblemError)
    def on_problem(request: Request, error: ProblemError) -> Response:
        return problem_response(request, error)

    @app.exception_handler(InputError)
    def on_input(request: Request, error: InputError) -> Response:
        return problem_response(request, ProblemError(422, "body-invalid", str(error)))

    @app.exception_handler(RequestValidationError)
    def on_validation(request: Request, error: RequestValidationError) -> Response:
        first: dict[str, Any] = dict(error.errors()[0])
        field = ".".join(str(part) for part in first["loc"][1:])
        return problem_response(request, ProblemError(422, "body-invalid", f"{field}: {first['msg']}", field=field))

    @app.exception_handler(HTTPException)
    def on_http(request: Request, error: HTTPException) -> Response:
        headers = dict(error.headers or {})
        path = _short(request.scope["path"])
        allowed = allowed_methods(request) if error.status_code in _OF_ROUTES else []
        if allowed and request.method not in allowed:
            headers["Allow"] = ", ".join(allowed)
            detail = f"{request.method} is not allowed on {path}, which takes {headers['Allow']}"
            return problem_response(request, ProblemError(405, "method-not-allowed", detail, headers=headers))
        if error.status_code == HTTPStatus.METHOD_NOT_ALLOWED and request.scope["path"].startswith("/v1/"):
            return problem_response(request, ProblemError(404, "not-found", f"{path}: nothing here"))
        if error.status_code == HTTPStatus.METHOD_NOT_ALLOWED:
            detail = f"{request.method} is not allowed on {path}"
            return problem_response(request, ProblemError(405, "method-not-allowed", detail, headers=headers))
        code = HTTPStatus(error.status_code).phrase.lower().replace(" ", "-")
        detail = f"{path}: nothing here" if error.status_code == HTTPStatus.NOT_FOUND else error.detail
        return problem_response(request, ProblemError(error.status_code, code, detail, headers=headers))

    @app.exception_handler(OperationalError)
    def on_database(request: Request, error: OperationalError) -> Response:
        log.error("the job database does not respond: %s", error.orig)
        detail = "the job database cannot be reached; try again later"
        return problem_response(request, ProblemError(503, "queue-unavailable", detail, headers={"Retry-After": "5"}))

    @app.exception_handler(BaseError)
    def on_store(request: Request, error: BaseError) -> Response:
        log.error("the store does not answer: %s", str(error).partition("\n")[0])
        detail = "the store of scenes cannot be reached; try again later"
        return problem_response(request, ProblemError(503, "store-unavailable", detail, headers={"Retry-After": "5"}))

    @app.exception_handler(ClientDisconnect)
    def on_disconnect(request: Request, error: ClientDisconnect) -> Response:
        return Response(status_code=400)  # nobody is left to read it

    @app.exception_handler(OSError)
    def on_storage(request: Request, error: OSError) -> Response:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise error
        log.error("cannot write: %s", error)
        detail = "the server's disk is full; nothing was written; try again when there is room"
        return problem_response(request, ProblemError(507, "storage-full", detail, headers={"Retry-After": "30"}))

    @app.exception_handler(Exception)
    def on_fault(request: Request, error: Exception) -> Response:
        # Starlette raises the exception again after this answer, so the server logs its traceback.
        return problem_response(request, ProblemError(500, "internal", "internal server error; see the server's log"))


def _short(path: str) -> str:
    """Return a path, shortened if need be: clients may send one of any length."""
    return path if len(path) <= _LONGEST_PATH else f"{path[:_LONGEST_PATH]}…"


def problem_response(request: HTTPConnection, problem: ProblemError) -> Response:
    """Return the problem document that answers `request`."""
    body = problem_document(problem, request.scope["path"], site_root(request))
    return Response(body, problem.status, problem.headers, PROBLEM_JSON)


def problem_document(problem: ProblemError, path: str, root: str = "") -> bytes:
    """Return the problem document of a request for the unquoted `path`; "" if there was no request.

    `root` is the quoted path under which a proxy serves the site.
    """
    body = {
        "type": "about:blank",
        "title": HTTPStatus(problem.status).phrase,
        "status": problem.status,
        "detail": " ".join(problem.detail.split()),
        "instance": root + quote(_short(path), errors="replace"),
        "code": problem.code,
    }
    if problem.field:
        body["field"] = problem.field
    # A client's text may hold lone surrogates, which JSON can express and UTF-8 cannot.
    return json.dumps(body, separators=(",", ":"), ensure_ascii=False).encode(errors="replace")
