"""The path prefix under which a proxy serves the site."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from urllib.parse import quote, unquote

from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send

from hgs_core.base.errors import InputError

__all__ = ["SiteRoot", "configured_root", "site_root"]

SETTING = "HGS_ROOT_PATH"
TOLD = "X-Forwarded-Prefix"  # sent by proxies that strip the prefix

_SAFE = "/-._~!$&'()*+,=:@"  # no ";", which would end a cookie's path
_PART = re.compile(r"(?!\.{1,2}$)[^/?#\\\x00-\x20\x7f]+(?: +[^/?#\\\x00-\x20\x7f]+)*")
_LONGEST = 200  # characters


def configured_root(given: str = "", environment: Mapping[str, str] = os.environ) -> str:
    """Return the path prefix of a proxy, from `given` or `HGS_ROOT_PATH`; "" for none.

    Raises:
        InputError: it is not a path.
    """
    text = given or environment.get(SETTING, "")
    root = _checked(text)
    if root is None:
        cure = "give the path of the proxy's location, such as /hgs"
        raise InputError(f"--root-path or {SETTING}", f"{text!r:.100} is not a URL path", cure)
    return root


def site_root(connection: HTTPConnection) -> str:
    """Return the quoted path before `/v1` in the client's URLs, such as `/hgs`; "" for none."""
    root: str = connection.scope.get("state", {}).get("site_root", "")
    return quote(root, safe=_SAFE)


class SiteRoot:
    """ASGI middleware that strips the root from request paths, unless the proxy has stripped it.

    Requests without the root are served, too: from this machine, and from proxies that strip it.
    """

    def __init__(self, app: ASGIApp, root: str = "") -> None:
        """Serve below `root`, unquoted and without a trailing slash."""
        self._app, self._root = app, root

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on; redirect the root without its trailing slash."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        root, path = self._root, scope["path"]
        if root and path == root and scope["type"] == "http":
            query = scope["query_string"].decode("latin-1")
            # Relative, since another proxy may have stripped an outer prefix.
            target = f"{quote(root.rpartition('/')[2], safe=_SAFE)}/{'?' if query else ''}{query}"
            await Response(status_code=308, headers={"Location": target})(scope, receive, send)
            return
        kept = bool(root) and path.startswith(f"{root}/")
        told = _checked(HTTPConnection(scope).headers.get(TOLD, "")) or ""
        # With two proxies, the first may strip and announce its own path while the second leaves its own.
        whole = root if told in ("", root) else told + root
        state = {**scope.get("state", {}), "site_root": whole}
        scope = {**scope, "state": state}
        if kept:
            scope["path"] = path[len(root) :]
            raw = scope.get("raw_path")
            if raw:
                scope["raw_path"] = b"/" + raw.split(b"/", root.count("/") + 1)[-1]
        await self._app(scope, receive, send)


def _checked(text: str) -> str | None:
    """Return a path unquoted, with a leading and no trailing slash; "" for the root, None if invalid."""
    parts = [part for part in unquote(text).strip("/").split("/") if part]
    good = len(text) <= _LONGEST and "//" not in text and all(_PART.fullmatch(part) for part in parts)
    return "".join(f"/{part}" for part in parts) if good else None
