"""A whole service under random faults, and the check of its promises: `scripts/soak`."""

__all__: list[str] = []
