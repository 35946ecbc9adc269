"""Child processes of a worker: limits, environment, outcome, silence."""

__all__: list[str] = []
