"""The durable queue: requests, workflows, recovery."""

__all__: list[str] = []
