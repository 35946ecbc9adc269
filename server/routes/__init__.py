"""Routes of the API, one router per resource of docs/protocol.md."""

__all__: list[str] = []
