"""Messages and endings of the stream."""

__all__: list[str] = []
