"""One client's stream: session, sending order, flow control."""

__all__: list[str] = []
