"""OpenAPI description of the API: routes, request bodies, required scopes and the form of every error."""

from __future__ import annotations

import warnings
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import BaseModel

from hgs_core.base.version import software_version
from server.access.scopes import needed_scope
from server.http.problems import PROBLEM_JSON
from server.routes import capture_checks, links, scenes, session, submissions, uploads

__all__ = ["describe_api"]

_BODIES: dict[tuple[str, str], type[BaseModel]] = {
    ("post", "/v1/captures/check"): capture_checks.Start,
    ("post", "/v1/jobs"): submissions.Submission,
    ("post", "/v1/links"): links.Wish,
    ("patch", "/v1/scenes/{scene_id}"): scenes.Changes,
    ("post", "/v1/session"): session.Given,
    ("post", "/v1/uploads"): uploads.Beginning,
}
"""Request bodies parsed by the routes themselves, which FastAPI cannot detect."""

_PROBLEM = {
    "type": "object",
    "required": ["type", "title", "status", "detail", "instance", "code"],
    "properties": {
        "type": {"type": "string"},
        "title": {"type": "string"},
        "status": {"type": "integer"},
        "detail": {"type": "string"},
        "instance": {"type": "string"},
        "code": {"type": "string"},
        "field": {"type": "string"},
    },
}


def describe_api(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI document of an application, without the viewer's files."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GET and HEAD of a route share a name, which is corrected below
        found = get_openapi(title="HGS", version=software_version(), routes=app.routes)
    found["paths"].pop("/{path}", None)
    found["servers"] = [{"url": "."}]  # relative to this document, under any path of a proxy
    components = found.setdefault("components", {})
    components["securitySchemes"] = {"key": {"type": "http", "scheme": "bearer"}}
    schemas = components.setdefault("schemas", {})
    schemas.pop("HTTPValidationError", None)
    schemas.pop("ValidationError", None)
    schemas["Problem"] = _PROBLEM
    for path, operations in found["paths"].items():
        for method, operation in operations.items():
            operation["operationId"] = f"{method} {path}"
            scope = needed_scope(method.upper(), path.replace("{", "").replace("}", ""))
            if scope is not None:
                operation["security"] = [{"key": []}]
                operation["description"] = f"{operation.get('description', '')} Requires the scope `{scope}`.".strip()
            operation["responses"].pop("422", None)
            problem = {"schema": {"$ref": "#/components/schemas/Problem"}}
            operation["responses"]["default"] = {"description": "A problem", "content": {PROBLEM_JSON: problem}}
            model = _BODIES.get((method, path))
            if model is not None:
                body = model.model_json_schema(ref_template="#/components/schemas/{model}")
                schemas.update(body.pop("$defs", {}))
                operation["requestBody"] = {"required": True, "content": {"application/json": {"schema": body}}}
    return dict(found)
