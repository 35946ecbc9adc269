"""Faults of a capture that would train to mush, found before it trains: poses, lenses, clocks, masks, pictures."""

__all__: list[str] = []
