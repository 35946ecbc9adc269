"""A run on disk: its folder, its stages from a capture to an encoded scene, and runs made of imported splats."""

__all__: list[str] = []
