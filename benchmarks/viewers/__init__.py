"""Our viewer beside others in one browser: `python -m benchmarks.viewers RUN`."""

__all__: list[str] = []
