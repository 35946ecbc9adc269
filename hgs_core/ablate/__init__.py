"""What each part of the method is worth: runs that differ in one thing, trained and scored alike."""

__all__: list[str] = []
