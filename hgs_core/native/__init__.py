"""The C++17 CPU kernels and their bindings: rasterization, the training loss and RMSprop, on numpy arrays."""

__all__: list[str] = []
