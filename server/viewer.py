"""The built browser client, served from the package's folder `viewer/`."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse, HTMLResponse
from starlette.exceptions import HTTPException

__all__ = ["VIEWER", "viewer_router"]

VIEWER = Path(__file__).resolve().parent / "viewer"

# Ours, because the system's table may lack .wasm or name .js text/plain, and browsers then refuse both.
_MEDIA_TYPES = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".ico": "image/x-icon",
    ".jpg": "image/jpeg",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".map": "application/json",
    ".mjs": "text/javascript; charset=utf-8",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
    ".wasm": "application/wasm",
    ".webp": "image/webp",
    ".woff2": "font/woff2",
}

_NOT_BUILT = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>HGS</title>
<h1>The viewer is not built</h1>
<p>The service runs, and its API answers under <a href="/v1/health">/v1</a>. To build the page, run
<code>npm ci &amp;&amp; npm run build</code> in the folder <code>web_client</code> and load this page again.</p>
</html>
"""


def viewer_router(folder: Path = VIEWER) -> APIRouter:
    """Return routes that serve the files of `folder`, and its index.html for every page address without a suffix."""
    router = APIRouter()
    folder = folder.resolve()

    @router.api_route("/{path:path}", methods=["GET", "HEAD"])
    def viewer_file(request: Request, path: str) -> Response:
        if path == "v1" or path.startswith("v1/"):
            raise HTTPException(404)
        if not (folder / "index.html").is_file():
            return HTMLResponse(_NOT_BUILT, 503, {"Cache-Control": "no-store"})
        file = (folder / path).resolve() if "\0" not in path else folder
        if not file.is_relative_to(folder):
            raise HTTPException(404)
        if not file.is_file():
            if Path(path).suffix:
                raise HTTPException(404)
            file = folder / "index.html"
        # The build names the files under assets/ by their content.
        hashed = file.parent.name == "assets"
        cache_control = "public, max-age=31536000, immutable" if hashed else "no-cache"
        media_type = _MEDIA_TYPES.get(file.suffix.lower(), "application/octet-stream")
        return FileResponse(file, media_type=media_type, headers={"Cache-Control": cache_control})

    return router
