"""The loss and the optimiser as Triton kernels; its modules need Triton."""

__all__: list[str] = []
