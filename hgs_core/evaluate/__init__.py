"""How good and how small a scene is: one metric per file, and the evaluation of a run."""

__all__: list[str] = []
