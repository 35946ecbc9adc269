"""The durable queue: job table, workflows, workers and the artifact store. Nothing here imports torch."""

__all__: list[str] = []
