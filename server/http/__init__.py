"""HTTP building blocks that know nothing of scenes or jobs: problems, conditions, codings, logs, limits."""

__all__: list[str] = []
