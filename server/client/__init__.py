"""The Python client of the stream."""

__all__: list[str] = []
