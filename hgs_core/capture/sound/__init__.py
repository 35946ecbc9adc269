"""The sound of a capture: tracks of videos, packets that browsers decode."""

__all__: list[str] = []
