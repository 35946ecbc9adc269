"""Uploaded captures: names, limits, files in pieces, and assembly."""

__all__: list[str] = []
