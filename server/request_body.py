"""Bodies of requests: bounded, JSON, and checked against a model."""

from __future__ import annotations

import json
from typing import TypeVar

from fastapi import Request
from pydantic import BaseModel, ValidationError

from server.problems import ProblemError

__all__ = ["MAX_BODY_BYTES", "read_json"]

MAX_BODY_BYTES = 64 << 10

Model = TypeVar("Model", bound=BaseModel)


async def read_json(request: Request, model: type[Model]) -> Model:
    """Read a request's JSON body as `model`.

    Raises:
        ProblemError: 413 too large, 415 or 400 not JSON, 422 a bad field.
    """
    # Asking for the media type also keeps out forms of other sites, which cannot send it without asking first.
    media_type = request.headers.get("Content-Type", "").partition(";")[0].strip().lower()
    if media_type != "application/json":
        raise ProblemError(415, "body-not-json", f"Content-Type is {media_type or 'missing'}; send application/json")
    body = bytearray()
    async for part in request.stream():
        body += part
        if len(body) > MAX_BODY_BYTES:
            raise ProblemError(413, "body-too-large", f"the body is larger than {MAX_BODY_BYTES} bytes")
    try:
        value = json.loads(body)
    except (ValueError, RecursionError) as error:
        raise ProblemError(400, "body-not-json", f"the body is not JSON: {error}") from error
    try:
        return model.model_validate(value)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        field = ".".join(str(part) for part in first["loc"])
        message = f"{field}: {first['msg']}" if field else f"body: {first['msg']}"
        raise ProblemError(422, "body-invalid", message, field=field) from error
