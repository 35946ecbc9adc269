"""One viewer's stream: session, order of sending, flow control."""

__all__: list[str] = []
