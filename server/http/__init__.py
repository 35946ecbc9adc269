"""HTTP apart from our data: problems, conditions, codings, logs, limits."""

__all__: list[str] = []
