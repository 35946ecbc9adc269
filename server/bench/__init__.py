"""Benchmarks of the stream: `hgs bench stream`."""

__all__: list[str] = []
