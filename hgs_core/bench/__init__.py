"""Speed and error of the rasterizers on synthetic scenes: what `hgs bench` runs."""

__all__: list[str] = []
