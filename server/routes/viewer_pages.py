"""The built browser client, served from the package's folder `viewer/`."""

from __future__ import annotations

import logging
import re
from pathlib import Path
from urllib.parse import quote

from fastapi import APIRouter, Request, Response
from fastapi.responses import HTMLResponse
from sqlalchemy.exc import OperationalError
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException

from jobs.records.keys import Scope
from server.access.visitors import LINK, Access
from server.http.conditional import entity_tag, respond, respond_compressed
from server.http.content_coding import preferred_coding
from server.http.media_types import MEDIA_TYPES
from server.http.problems import ProblemError
from server.http.security_headers import CONSOLE_POLICY, EMBEDDABLE_POLICY
from server.routes.poster import Poster
from server.service import Service, ServiceDep

__all__ = ["VIEWER", "viewer_router"]

log = logging.getLogger("hgs.server")

VIEWER = Path(__file__).resolve().parents[1] / "viewer"

# Compressed copies made by the build where they are smaller; the best one first.
_CODED = {"br": ".br", "gzip": ".gz"}

# At most one folder deep, and no name begins with a dot: no path leads out of the folder.
_FILE = re.compile(r"(?:[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}/)?[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}")

# The build's form of addresses relative to the server's root.
_OF_ROOT = re.compile(r"""((?:href|src)=["'])\./""")

_NAME = r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,63}"
_SCENE_PAGE = re.compile(f"view/({_NAME})/?")

# Pages by address, as in page_address.ts, with their security policies.
_PAGES = (
    (re.compile("|index\\.html"), "index.html", CONSOLE_POLICY),
    (re.compile("new/?"), "new.html", CONSOLE_POLICY),
    (re.compile(f"job/{_NAME}/?"), "job.html", CONSOLE_POLICY),
    (_SCENE_PAGE, "view.html", EMBEDDABLE_POLICY),
)

_NOT_BUILT = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>HGS</title>
<h1>The viewer is not built</h1>
<p>The service is running, and its API is at <a href="./v1/health">/v1</a>. To build the page, run
<code>npm ci &amp;&amp; npm run build</code> in the folder <code>web_client</code> and load this page again.</p>
</html>
"""


def viewer_router(folder: Path = VIEWER) -> APIRouter:
    """Return routes that serve the files of `folder`: the pages at their addresses, and their resources."""
    router = APIRouter()

    @router.api_route("/{path:path}", methods=["GET", "HEAD"])
    async def viewer_file(request: Request, path: str, service: ServiceDep) -> Response:
        scene = _SCENE_PAGE.fullmatch(path)
        if scene is None:
            return await run_in_threadpool(_found, request, folder, path)
        seen = await _may_see(service.access, request, scene[1])
        poster = await run_in_threadpool(_poster, request, service, scene[1]) if seen else None
        answer = await run_in_threadpool(_scene_page, request, folder, path, poster)
        for name in ("Cookie", "Authorization"):  # the response depends on these
            answer.headers.add_vary_header(name)
        return answer

    return router


def _found(request: Request, folder: Path, path: str) -> Response:
    """Return the page or the file at a path."""
    if path == "v1" or path.startswith("v1/"):
        raise HTTPException(404)
    for address, page, policy in _PAGES:
        if address.fullmatch(path):
            return _page(request, folder / page, policy)
    file = folder / path
    if not _FILE.fullmatch(path) or file.suffix not in MEDIA_TYPES or not file.is_file():
        if "text/html" in request.headers.get("Accept", ""):
            # This page reports that nothing is there.
            answer = _page(request, folder / "index.html", CONSOLE_POLICY)
            answer.status_code = 404 if answer.status_code == 200 else answer.status_code
            answer.headers.append("Vary", "Accept")
            return answer
        raise HTTPException(404, headers={"Vary": "Accept"})
    return _file(request, file, CONSOLE_POLICY)


def _scene_page(request: Request, folder: Path, path: str, poster: Poster | None) -> Response:
    file = folder / "view.html"
    if poster is None or not file.is_file():
        return _found(request, folder, path)
    page, policy = poster.painted_on(_relative(request, file))
    answer = respond_compressed(request, page.encode(), MEDIA_TYPES[".html"])
    answer.headers["Content-Security-Policy"] = policy
    return answer


async def _may_see(access: Access, request: Request, scene: str) -> bool:
    """Return whether the scene's picture may be sent: a page without a key must not reveal which scenes exist."""
    try:
        if await access.open_to(request):
            return True
        visitor = await access.visitor(request)
    except OperationalError:
        return False
    if visitor is None or not visitor.allows(Scope.VIEW):
        return False
    return visitor.link is None or visitor.link.scene == scene


def _poster(request: Request, service: Service, scene: str) -> Poster | None:
    """Return the poster of a scene for its page; None if there is no thumbnail or no such scene."""
    try:
        shape = service.catalogue.scene(scene).poster_shape
    except ProblemError:
        return None
    # The page itself reports errors of the store.
    except Exception as error:
        log.warning("scene %s: its page has no poster: %s", scene, error)
        return None
    if shape is None:
        return None
    link = request.query_params.get(LINK)
    query = "" if link is None else f"?{LINK}={quote(link, safe='')}"
    return Poster(f"{_root(request)}v1/scenes/{scene}/thumbnail{query}", shape)


def _page(request: Request, file: Path, policy: str) -> Response:
    """Return a page of the build, with addresses relative to the page.

    So it works under any path of a proxy.
    """
    if not file.is_file():
        return HTMLResponse(_NOT_BUILT.replace('"./', f'"{_root(request)}'), 503, {"Cache-Control": "no-store"})
    response = respond_compressed(request, _relative(request, file).encode(), MEDIA_TYPES[file.suffix])
    response.headers["Content-Security-Policy"] = policy
    return response


def _relative(request: Request, file: Path) -> str:
    return _OF_ROOT.sub(rf"\1{_root(request)}", file.read_text(encoding="utf-8"))


def _root(request: Request) -> str:
    """Return the server's root, relative to the requested page."""
    return "../" * (_raw_path(request).count("/") - 1) or "./"


def _raw_path(request: Request) -> str:
    """Return the path as the browser sent it: an escaped slash is not a separator."""
    raw: bytes = request.scope.get("raw_path") or request.scope["path"].encode()
    return raw.decode("latin-1")


def _file(request: Request, file: Path, policy: str) -> Response:
    coded = {coding: file.with_name(file.name + suffix) for coding, suffix in _CODED.items()}
    available = [coding for coding, path in coded.items() if path.is_file()]
    coding = preferred_coding(request.headers.get("Accept-Encoding"), available)
    body = coded.get(coding, file).read_bytes()
    # The build names the files under assets/ after their content.
    cache_control = "public, max-age=31536000, immutable" if file.parent.name == "assets" else "no-cache"
    media_type = MEDIA_TYPES[file.suffix]
    response = respond(request, body, media_type, etag=entity_tag(body), cache_control=cache_control, coding=coding)
    response.headers["Content-Security-Policy"] = policy
    return response
