"""Speed and error of the rasterizers: `hgs bench raster`."""

__all__: list[str] = []
