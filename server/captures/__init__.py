"""Listing and checking of captures for the API, in separate processes."""

__all__: list[str] = []
