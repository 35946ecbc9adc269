"""Lens models, and pictures freed from their distortion."""

__all__: list[str] = []
