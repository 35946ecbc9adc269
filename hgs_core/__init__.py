"""The science of HGS: captures, scenes, rendering, training, coding and evaluation.

Nothing here imports a web framework, a queue or a database. Heavy libraries (torch, pycolmap, av) are imported by
the modules that need them, never by this package itself.
"""

__all__: list[str] = []
