"""The exception that a request is refused with; light, so that processes without a web library can raise it."""

from __future__ import annotations

__all__ = ["ProblemError"]


class ProblemError(Exception):
    """A request that is answered with a problem document; the codes are those of docs/protocol.md."""

    def __init__(
        self, status: int, code: str, detail: str, *, field: str = "", headers: dict[str, str] | None = None
    ) -> None:
        """Keep the HTTP status, the code for programs, one line for people and, if there is one, the bad field."""
        self.status = status
        self.code = code
        self.detail = detail
        self.field = field
        self.headers = headers
        super().__init__(detail)
