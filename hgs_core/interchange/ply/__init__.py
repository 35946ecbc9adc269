"""PLY files: static, compressed and spacetime splats, and sequences of them."""

__all__: list[str] = []
