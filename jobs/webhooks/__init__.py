"""Webhooks: rules for addresses, and delivery."""

__all__: list[str] = []
