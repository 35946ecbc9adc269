"""How close a picture is to the truth: one metric per file, on tensors alone."""

__all__: list[str] = []
