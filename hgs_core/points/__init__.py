"""The first points of a scene: features, structure from motion, a plane sweep, and how points move between frames."""

__all__: list[str] = []
