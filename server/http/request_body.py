"""Request bodies: size limit, JSON, and validation against a model."""

from __future__ import annotations

import json
import math
from typing import Any, TypeVar

from fastapi import Request
from pydantic import BaseModel, ValidationError

from hgs_core.base.storable_text import is_storable
from server.http.problems import ProblemError

__all__ = ["MAX_BODY_BYTES", "read_bytes", "read_json"]

MAX_BODY_BYTES = 64 << 10
_WHOLE_DIGITS = 19  # digits of the largest 64-bit integers

Model = TypeVar("Model", bound=BaseModel)


async def read_json(request: Request, model: type[Model], *, bounded: str = "") -> Model:
    """Read a request's JSON body as `model`.

    `bounded` names a field with numbers that the caller checks against ranges of its own: they may be infinite or NaN,
    so that the refusal can name the range.

    Raises:
        ProblemError: 413 too large, 415 or 400 not JSON, 422 a bad field; also NaN, infinities, NUL and half
            surrogate pairs, anywhere.
    """
    try:
        value = json.loads(await read_bytes(request), parse_int=_whole_number)
    except (ValueError, RecursionError) as error:
        raise ProblemError(400, "body-not-json", f"the body is not JSON: {error}") from error
    _require_plain(value, bounded)
    try:
        return model.model_validate(value)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise _bad_field(".".join(str(part) for part in first["loc"]), first["msg"]) from error


async def read_bytes(request: Request, most: int = MAX_BODY_BYTES) -> bytes:
    """Read the body of a request that says that it is JSON, unparsed.

    Raises:
        ProblemError: 413 larger than `most` bytes, 415 of another type.
    """
    # Requiring this type also stops other sites' forms, which cannot send it without a preflight.
    media_type = request.headers.get("Content-Type", "").partition(";")[0].strip().lower()
    if media_type != "application/json":
        raise ProblemError(415, "body-not-json", f"Content-Type is {media_type or 'missing'}; send application/json")
    body = bytearray()
    async for part in request.stream():
        body += part
        if len(body) > most:
            raise ProblemError(413, "body-too-large", f"the body is larger than {most} bytes")
    return bytes(body)


def _whole_number(digits: str) -> float:
    """Return an int, or beyond 64 bits a float, possibly infinite: Python refuses ints of thousands of digits."""
    return int(digits) if len(digits) <= _WHOLE_DIGITS else float(digits)


def _require_plain(value: Any, bounded: str) -> None:
    """Reject values that no database or response can hold, and name their field."""
    waiting: list[tuple[str, Any]] = [("", value)]  # an explicit stack: the sender chooses the depth
    while waiting:
        path, value = waiting.pop()
        elsewhere = bool(bounded) and path.startswith(f"{bounded}.")
        if isinstance(value, float) and not math.isfinite(value) and not elsewhere:
            raise _bad_field(path, f"{value} is not a finite number")
        if isinstance(value, str) and not is_storable(value):
            raise _bad_field(path, f"{value[:80]!a} contains NUL or half a surrogate pair")
        if isinstance(value, dict):
            for name in value:
                if not is_storable(name):
                    raise _bad_field(path, f"the name {name[:80]!a} contains NUL or half a surrogate pair")
            waiting += ((f"{path}.{name}" if path else name, one) for name, one in value.items())
        elif isinstance(value, list):
            waiting += ((f"{path}.{place}", one) for place, one in enumerate(value))


def _bad_field(field: str, problem: str) -> ProblemError:
    return ProblemError(422, "body-invalid", f"{field or 'body'}: {problem}", field=field)
