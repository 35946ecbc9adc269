"""The CUDA backend: every stage of rendering and its derivative as Triton kernels (docs/numerics.md, "Triton").

Nothing is imported here: `device` can be asked without Triton, the other modules need it.
"""

__all__: list[str] = []
