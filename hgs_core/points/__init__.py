"""The first points of a scene: features, structure from motion, stereo, a plane sweep, and how points move."""

__all__: list[str] = []
