"""SPZ files."""

__all__: list[str] = []
