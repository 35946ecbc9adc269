"""Bytes and errors of the scene codec: `hgs bench codec`."""

__all__: list[str] = []
