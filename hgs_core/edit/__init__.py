"""Edits of trained scenes: crop, trim, turn, clean and merge. Scenes in, scenes out."""

__all__: list[str] = []
