"""What can be done to a scene that is trained: crop, trim, turn, clean and merge it. Scenes in, scenes out."""

__all__: list[str] = []
