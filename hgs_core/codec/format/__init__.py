"""The format of docs/format.md without the encoder: containers, attributes, manifest, decoding."""

__all__: list[str] = []
