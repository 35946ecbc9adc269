"""Origin policy: pages of other hosts may read scenes if their origin is allowed, and may never change anything."""

from __future__ import annotations

from dataclasses import dataclass

from starlette.requests import HTTPConnection

from server.http.problems import ProblemError

__all__ = ["OriginPolicy"]


@dataclass(frozen=True)
class OriginPolicy:
    """Origins with read access besides the server's own, e.g. https://example.org; "*" allows all."""

    readers: frozenset[str] = frozenset()

    def same_site(self, connection: HTTPConnection) -> bool:
        """Return whether the request comes from a page of this server, or from no page."""
        origin = connection.headers.get("Origin")
        return origin is None or origin.partition("://")[2] == connection.headers.get("Host")

    def require_same_site(self, connection: HTTPConnection) -> None:
        """Refuse a change requested by a page of another site.

        Raises:
            ProblemError: 403.
        """
        if not self.same_site(connection):
            detail = f"a page of {connection.headers['Origin']} may not change anything on this server"
            raise ProblemError(403, "origin-not-allowed", detail)

    def may_read(self, connection: HTTPConnection) -> bool:
        """Return whether the requesting page, if any, may read scenes: browsers do not apply CORS to WebSockets."""
        return self.same_site(connection) or connection.headers["Origin"] in self.readers or "*" in self.readers
