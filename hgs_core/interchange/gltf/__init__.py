"""GLB files with KHR_gaussian_splatting."""

__all__: list[str] = []
