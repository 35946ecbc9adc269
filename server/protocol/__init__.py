"""Messages of the stream, and its endings."""

__all__: list[str] = []
