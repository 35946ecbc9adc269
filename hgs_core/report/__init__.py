"""A finished run as one HTML page (docs/evaluation.md)."""

__all__: list[str] = []
