"""Connections: the HTTP server, its limits, the WebSocket protocol."""

__all__: list[str] = []
