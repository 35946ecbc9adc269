"""The error of a decoder about bytes that are not a valid chunk."""

from __future__ import annotations

from hgs_core.base.errors import InputError

__all__ = ["ChunkError"]


class ChunkError(InputError):
    """A chunk that is truncated, damaged or not of this format.

    The message names the byte, the record, the value found and what was expected.
    """

    def __init__(self, byte: int, record: str, found: object, expected: object) -> None:
        super().__init__(f"chunk: byte {byte}: {record}", f"is {found}, expected {expected}", "fetch the chunk again")
        self.byte = byte
        self.record = record
        self.found = found
        self.expected = expected
