"""Poses and focal lengths of cameras from their videos alone."""

__all__: list[str] = []
