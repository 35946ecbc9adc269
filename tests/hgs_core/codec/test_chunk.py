from __future__ import annotations

import base64
import json
import math
import struct
import tracemalloc
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard

from hgs_core.codec import ChunkError, decode_chunk

VECTORS = Path(__file__).resolve().parents[2] / "vectors"
VALID = sorted(path.stem for path in VECTORS.glob("*.chunk"))
INVALID: dict[str, Any] = json.loads((VECTORS / "invalid.json").read_text())


@pytest.mark.parametrize("name", VALID)
def test_a_valid_chunk_decodes_to_the_recorded_bits(name: str) -> None:
    chunk = decode_chunk((VECTORS / f"{name}.chunk").read_bytes())
    expected = json.loads((VECTORS / f"{name}.json").read_text())
    assert (chunk.kind.name.lower(), chunk.count) == (expected["kind"], expected["count"])
    assert json.loads(json.dumps([chunk.time_range, chunk.box])) == [expected["time_range"], expected["box"]]
    recorded = {name: base64.b64decode(text) for name, text in expected["float32"].items()}
    assert {name: array.tobytes() for name, array in chunk.arrays.items()} == recorded


@pytest.mark.parametrize("name", INVALID)
def test_a_damaged_chunk_is_refused_with_byte_and_record(name: str) -> None:
    with pytest.raises(ChunkError) as caught:
        decode_chunk((VECTORS / "invalid" / f"{name}.chunk").read_bytes())
    assert {"byte": caught.value.byte, "record": caught.value.record} == INVALID[name]
    assert "\n" not in str(caught.value)


def scalar_stream(data: bytes, wanted: int) -> list[list[float]]:
    """The reference: docs/format.md followed word by word, one Python number at a time."""
    count = struct.unpack_from("<I", data, 8)[0]
    for i in range(data[7]):
        at = 64 + 44 * i
        identity, quantiser, transform, components, bits = data[at : at + 5]
        offset, length = struct.unpack_from("<II", data, at + 8)
        step, *origin = struct.unpack_from("<5f", data, at + 24)
        if identity == wanted:
            break
    raw = zstandard.ZstdDecompressor().decompress(data[offset : offset + length])
    if quantiser == 1:
        codes, m = [], 0
        for n in range(count):
            m += sum(raw[p * count + n] << 8 * p for p in range(math.ceil(3 * bits / 8)))
            codes.append([sum((m >> 3 * k + axis & 1) << k for k in range(bits)) for axis in range(3)])
    else:
        planes = math.ceil(bits / 8)
        codes = [
            [sum(raw[(c * planes + p) * count + n] << 8 * p for p in range(planes)) for c in range(components)]
            for n in range(count)
        ]
    signed = [[z // 2 if z % 2 == 0 else -(z + 1) // 2 for z in row] for row in codes]
    if transform == 1:
        for n in range(count):
            before = codes[n - 1] if n else [0] * components
            codes[n] = [(x + y) % 2**bits for x, y in zip(before, signed[n], strict=True)]
    if transform == 2:
        codes = [[(g + s[1]) % 2**bits, g, (g + s[2]) % 2**bits] for (g, *_), s in zip(codes, signed, strict=True)]

    def f32(x: float) -> float:
        return struct.unpack("<f", struct.pack("<f", x))[0]

    values = [[f32(o + f32(code * step)) for code, o in zip(row, origin, strict=False)] for row in codes]
    if quantiser == 2:
        for n, row in enumerate(values):
            a, b, c = row
            row.insert(raw[-count:][n], f32(math.sqrt(max(0.0, 1 - (a * a + b * b + c * c)))))
    return values


@pytest.mark.parametrize("name", VALID)
def test_every_attribute_is_what_the_specification_says(name: str) -> None:
    data = (VECTORS / f"{name}.chunk").read_bytes()
    chunk = decode_chunk(data)
    ids = {"position": 1, "log_scale": 2, "rotation": 3, "opacity": 4, "rgb": 5, "time_center": 16,
           "time_log_precision": 17, "time_exponent": 18, "velocity": 19, "acceleration": 20, "jerk": 21,
           "turning": 22}  # fmt: skip
    for attribute, values in chunk.attributes.items():
        np.testing.assert_array_equal(values, scalar_stream(data, ids[attribute]), err_msg=attribute)


def test_the_coefficients_are_unscaled_by_powers_of_two() -> None:
    data = (VECTORS / "dynamic.chunk").read_bytes()
    chunk = decode_chunk(data)
    exponents = [row[0] for row in scalar_stream(data, 18)]
    for order, identity in enumerate((19, 20, 21), start=1):
        for n, row in enumerate(scalar_stream(data, identity)):
            assert chunk.arrays["motion"][n, order].tolist() == [x * 2.0 ** (order * exponents[n]) for x in row]
    for n, row in enumerate(scalar_stream(data, 22)):
        assert chunk.arrays["rotation"][n, 1].tolist() == [x * 2.0 ** exponents[n] for x in row]


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """Damage a chunk somewhere, and make its checksum right again so that the fault is met."""
    changed = bytearray(data)
    how = rng.integers(4)
    table_end = 64 + 44 * data[7]
    if how == 0:  # one bit anywhere
        changed[rng.integers(len(changed))] ^= 1 << rng.integers(8)
    elif how == 1:  # a byte of header or table
        changed[rng.integers(table_end)] = rng.integers(256)
    elif how == 2:  # a whole number of header or table
        struct.pack_into("<I", changed, 4 * rng.integers(table_end // 4), rng.choice([0, 1, 2**20, 2**31, 2**32 - 1]))
    else:  # bytes lost or gained, and the stated length made to agree
        at = rng.integers(64, len(changed))
        changed[at : at + rng.integers(40)] = rng.bytes(rng.integers(40))
        struct.pack_into("<I", changed, 56, len(changed))
    body = bytes(changed[:-4])
    return body + struct.pack("<I", zlib.crc32(body))


@pytest.mark.parametrize("name", ["static", "dynamic"])
def test_thousands_of_damaged_chunks_give_chunk_errors_and_bounded_memory(name: str) -> None:
    data = (VECTORS / f"{name}.chunk").read_bytes()
    rng = np.random.default_rng(0)
    refused = 0
    tracemalloc.start()
    for _ in range(2000):
        try:
            chunk = decode_chunk(mutated(data, rng))
        except ChunkError:
            refused += 1
        else:
            assert all(np.isfinite(array).all() for array in chunk.arrays.values())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert refused > 1000
    assert peak < 4 << 20


@pytest.mark.parametrize("name", ["static", "dynamic"])
def test_every_truncation_is_refused(name: str) -> None:
    data = (VECTORS / f"{name}.chunk").read_bytes()
    for length in range(len(data)):
        with pytest.raises(ChunkError):
            decode_chunk(data[:length])
