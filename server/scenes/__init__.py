"""Published scenes in memory: catalogue, index, growth, chunk cache."""

__all__: list[str] = []
