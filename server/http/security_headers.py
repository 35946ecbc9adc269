"""What browsers may do with the answers: content security policies and their companions."""

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
        "img-src 'self' data:",  # the build puts small pictures into the style sheet
        "connect-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
    )
)
"""Of pages of the viewer that any site may show in a frame, and of what they load."""

CONSOLE_POLICY = f"{EMBEDDABLE_POLICY}; frame-ancestors 'none'"
"""Of pages on which jobs are cancelled: in a frame, a click could be borrowed."""

REPORT_POLICY = "; ".join(
    (
        "sandbox allow-scripts",  # of an origin of its own: whatever it holds can change nothing on this server
        "default-src 'none'",
        "img-src data:",
        "style-src 'unsafe-inline'",
        "script-src 'unsafe-inline'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
"""Of a run's report, one page with all that it shows inside."""

_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",  # what is no page of ours loads nothing
    "Referrer-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


class SecurityHeaders:
    """ASGI middleware that adds to every answer the headers that it does not have."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on and complete its answer."""

        async def send_with_headers(message: Message) -> None:
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        await self._app(scope, receive, send_with_headers)
