"""Captures that clients send: names, limits, files that arrive in pieces, and folders that appear whole."""

__all__: list[str] = []
