"""Backups of a home, and their restoration."""

__all__: list[str] = []
