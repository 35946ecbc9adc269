"""Database tables: jobs, workers, keys, announcements."""

__all__: list[str] = []
