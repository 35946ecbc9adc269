"""Child processes of a worker: limits, sandbox, environment, outcome, silence."""

__all__: list[str] = []
