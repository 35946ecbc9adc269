"""From the streams of a chunk to the values of its attributes (docs/format.md, "Values")."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base import morton
from hgs_core.codec.format.attributes import Attribute
from hgs_core.codec.format.chunk import Stream
from hgs_core.codec.format.format_error import ChunkError
from hgs_core.codec.format.quantise import MAX_BITS
from hgs_core.codec.format.streams import decompress, from_planes, undo_transform

__all__ = ["check_entry", "read_codes", "read_values"]


def check_entry(stream: Stream, attribute: Attribute) -> None:
    """Check an attribute's row of the table against the attribute's definition.

    Raises:
        ChunkError: a number of the row is not what the format allows.
    """
    bits = stream.grid.bits
    if stream.components != attribute.components:
        raise ChunkError(stream.at + 1, f"{_record(attribute)} components", stream.components, attribute.components)
    if not 1 <= bits <= MAX_BITS:
        raise ChunkError(stream.at + 2, f"{_record(attribute)} bits", bits, f"1 to {MAX_BITS}")
    if stream.transform not in attribute.transforms:
        expected = sorted(attribute.transforms)
        raise ChunkError(stream.at + 3, f"{_record(attribute)} transform", stream.transform, expected)
    if len(stream.planes) != attribute.planes(bits):
        raise ChunkError(stream.at + 4, f"{_record(attribute)} planes", len(stream.planes), attribute.planes(bits))
    if not 0 < stream.grid.step < np.inf:
        raise ChunkError(stream.at + 5, f"{_record(attribute)} step", stream.grid.step, "above 0 and finite")


def read_codes(stream: Stream, attribute: Attribute, rows: int) -> NDArray[np.unsignedinteger[Any]]:
    """Return the codes [C, rows] of a stream.

    Raises:
        ChunkError: a plane is not a frame of that many bytes, or a code has more bits than the stream states.
    """
    # All components together: a chunk of a thousand splats costs as many operations as one of a hundred thousand.
    planes = np.frombuffer(_content(stream, attribute, rows), np.uint8).reshape(-1, rows)
    bits = stream.grid.bits
    if attribute.morton:
        try:
            return morton.grid_points(planes, bits)
        except ValueError as error:
            raise ChunkError(stream.data_at[0], f"{_record(attribute)} codes", error, f"below 2^{3 * bits}") from error
    each = (bits + 7) // 8
    # What is too large shows in the last plane of a component.
    if bits % 8 and planes[each - 1 :: each].max() >> bits % 8:
        raise _too_large(stream, attribute, from_planes(planes, bits))
    return undo_transform(from_planes(planes, bits), bits, stream.transform)


def read_values(stream: Stream, attribute: Attribute, rows: int) -> NDArray[np.float32]:
    """Return the values [rows, C] of a stream; infinite, with a warning, where a damaged grid overflows.

    Raises:
        ChunkError: as `read_codes`.
    """
    return stream.grid.decode(read_codes(stream, attribute, rows))


def _content(stream: Stream, attribute: Attribute, rows: int) -> bytes:
    """Return the planes one after the other."""
    planes: list[bytes] = []
    try:
        for frame in stream.planes:
            planes.append(decompress(frame, rows))
    except ValueError as error:
        p = len(planes)
        record = f"{_record(attribute)} plane {p}"
        raise ChunkError(stream.data_at[p], record, error, f"a zstd frame of {rows} bytes") from error
    return planes[0] if len(planes) == 1 else b"".join(planes)


def _too_large(stream: Stream, attribute: Attribute, codes: NDArray[np.unsignedinteger[Any]]) -> ChunkError:
    """Return the error of the first component with a code of too many bits: its largest code's."""
    bits = stream.grid.bits
    c = int((codes >> bits).any(axis=1).argmax())
    row = int(codes[c].argmax())
    at = stream.data_at[c * ((bits + 7) // 8)]
    return ChunkError(at, f"{_record(attribute)} code of row {row}", codes[c, row], f"below 2^{bits}")


def _record(attribute: Attribute) -> str:
    return f"attribute {attribute.id} ({attribute.name})"
