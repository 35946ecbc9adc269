"""Videos, picture files and masks: decoding, numbering, orientation and colours."""

__all__: list[str] = []
