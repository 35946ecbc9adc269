"""Ablation of the method: runs that differ in one thing, trained and scored alike."""

__all__: list[str] = []
