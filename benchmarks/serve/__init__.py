"""The cost of many viewers, well-behaved and not: `python -m benchmarks.serve`."""

__all__: list[str] = []
