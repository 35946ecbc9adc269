"""Benchmarks of `hgs bench`: rasterizers, codec, whole trainings."""

__all__: list[str] = []
