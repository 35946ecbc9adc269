"""Jobs as clients read them: JSON, queries, logs, events."""

__all__: list[str] = []
