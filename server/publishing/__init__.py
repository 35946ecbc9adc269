"""Static publication: a folder or a bucket for any web server."""

__all__: list[str] = []
