"""Which pixels and which points move."""

__all__: list[str] = []
