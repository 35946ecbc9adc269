"""Readers of cameras: one module for each format in which calibrations are written."""

__all__: list[str] = []
