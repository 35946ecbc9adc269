"""The kernels themselves: Triton's dialect of Python, which no type checker reads."""

__all__: list[str] = []
