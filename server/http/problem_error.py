"""The exception of a rejected request; it imports no web library."""

from __future__ import annotations

__all__ = ["ProblemError"]


class ProblemError(Exception):
    """A request that is answered with a problem document; docs/rest.md lists the codes."""

    def __init__(
        self, status: int, code: str, detail: str, *, field: str = "", headers: dict[str, str] | None = None
    ) -> None:
        """Keep the HTTP status, the code for programs, one line for people and, if there is one, the invalid field."""
        self.status = status
        self.code = code
        self.detail = detail
        self.field = field
        self.headers = headers
        super().__init__(detail)
