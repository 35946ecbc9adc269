"""Routes of the API, one router per resource of docs/rest.md."""

__all__: list[str] = []
