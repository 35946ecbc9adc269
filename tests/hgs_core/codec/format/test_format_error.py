from __future__ import annotations

from hgs_core.base.errors import InputError
from hgs_core.codec.format.format_error import ChunkError


def test_the_message_names_byte_record_and_both_values_in_one_line() -> None:
    error = ChunkError(16, "total length", 99, "at most 80")
    assert str(error) == "chunk: byte 16: total length: is 99, expected at most 80; fetch the chunk again"
    assert (error.byte, error.record, error.found, error.expected) == (16, "total length", 99, "at most 80")
    assert isinstance(error, InputError)
