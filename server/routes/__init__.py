"""One router per resource of docs/protocol.md."""
