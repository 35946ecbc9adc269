"""How coarsely a scene can be encoded within a loss, and training further as it decodes. Opens no file."""

__all__: list[str] = []
