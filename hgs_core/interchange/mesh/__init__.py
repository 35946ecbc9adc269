"""Triangles of files that people have: PLY, OBJ and GLB."""

__all__: list[str] = []
