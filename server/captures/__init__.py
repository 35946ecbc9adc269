"""Captures as the API lists and checks them, in processes of their own."""

__all__: list[str] = []
