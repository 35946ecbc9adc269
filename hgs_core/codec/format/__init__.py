"""What docs/format.md says, and nothing about how chunks are made small: containers, attributes, manifest, decoding."""

__all__: list[str] = []
