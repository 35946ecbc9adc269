"""The header `Idempotency-Key`: requests with one key make one job (docs/rest.md)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from fastapi import Request

from jobs.queue.client import KeyReusedError
from server.http.problem_error import ProblemError

__all__ = ["IDEMPOTENCY_KEY", "idempotency_key", "refusing_reused_keys"]

IDEMPOTENCY_KEY = "Idempotency-Key"


def idempotency_key(request: Request) -> str:
    """Return the key of a request; "" without one."""
    return request.headers.get(IDEMPOTENCY_KEY, "")


@contextmanager
def refusing_reused_keys() -> Iterator[None]:
    """Answer 422 where the key belongs to another request."""
    try:
        yield
    except KeyReusedError as error:
        raise ProblemError(422, "idempotency-key-reused", str(error), field=IDEMPOTENCY_KEY) from error
