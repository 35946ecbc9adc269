"""A finished run as one HTML page (docs/report.md)."""

__all__: list[str] = []
