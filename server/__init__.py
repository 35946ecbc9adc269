"""HTTP and WebSocket service, and the `hgs` command line.

The process that serves the API never imports torch; only the commands that train or measure do.
"""

__all__: list[str] = []
