"""The store of published scenes: chunks, manifests, locks, checks."""

__all__: list[str] = []
