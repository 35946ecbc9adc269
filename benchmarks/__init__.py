"""Benchmarks of the project itself: they need a checkout, and are no part of an installation."""

__all__: list[str] = []
