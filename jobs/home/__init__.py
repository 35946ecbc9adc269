"""The home of an installation: settings, database, object store."""

__all__: list[str] = []
