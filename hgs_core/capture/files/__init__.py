"""Files of a capture, opened within bounds: text, arrays, containers, names."""

__all__: list[str] = []
