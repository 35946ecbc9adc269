"""A capture on disk becomes cameras, a clock, frames on demand, and the first points of the scene."""

__all__: list[str] = []
