"""The training iterations of two checkouts, in turn: `python -m benchmarks.against CHECKOUT`."""

__all__: list[str] = []
