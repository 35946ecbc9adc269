"""Content security policies and related response headers."""

from __future__ import annotations

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["CONSOLE_POLICY", "EMBEDDABLE_POLICY", "REPORT_POLICY", "SecurityHeaders"]

EMBEDDABLE_POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self' 'wasm-unsafe-eval'",  # chunks are decompressed by WebAssembly
        "worker-src 'self'",
        "style-src 'self'",
        "img-src 'self' data:",  # the build embeds small pictures in the style sheet
        "connect-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
    )
)
"""Policy of the viewer's pages that any site may embed, and of their resources."""

CONSOLE_POLICY = f"{EMBEDDABLE_POLICY}; frame-ancestors 'none'"
"""Policy of pages that can cancel jobs: never in a frame, where clicks could be hijacked."""

REPORT_POLICY = "; ".join(
    (
        "sandbox allow-scripts",  # an origin of its own: its scripts can change nothing on this server
        "default-src 'none'",
        "img-src data:",
        "style-src 'unsafe-inline'",
        "script-src 'unsafe-inline'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
"""Policy of a run's report, a self-contained page."""

_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",  # everything but our pages loads nothing
    "Referrer-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


class SecurityHeaders:
    """ASGI middleware that adds missing security headers to every response."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on and complete the headers of its response."""

        async def send_with_headers(message: Message) -> None:
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        await self._app(scope, receive, send_with_headers)
