"""The trainer. Import its modules directly: only `config` is free of torch."""

__all__: list[str] = []
