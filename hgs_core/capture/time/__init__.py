"""Clocks of cameras: time stamps, time codes, sync files."""

__all__: list[str] = []
