"""The base of every room: errors that people can act on, progress, files that appear whole, and the version."""

__all__: list[str] = []
