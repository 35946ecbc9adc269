"""Triangles of files that people have: PLY, OBJ and GLB."""

from __future__ import annotations
