from __future__ import annotations

import base64
import json
import math
import struct
import tracemalloc
from typing import Any

import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st

from hgs_core.codec import ChunkError, decode_chunk
from hgs_core.codec.format.decode import logits, time_exponents
from scripts.fuzz_codec import mutated, sealed, try_decoder
from tests.conftest import REPOSITORY

VECTORS = REPOSITORY / "tests" / "vectors"
VALID = sorted(path.stem for path in VECTORS.glob("*.chunk"))
INVALID: dict[str, Any] = json.loads((VECTORS / "invalid.json").read_text())


@pytest.mark.parametrize("name", VALID)
def test_a_valid_chunk_decodes_to_the_recorded_bits(name: str) -> None:
    chunk = decode_chunk((VECTORS / f"{name}.chunk").read_bytes())
    expected = json.loads((VECTORS / f"{name}.json").read_text())
    assert (chunk.kind.name.lower(), chunk.count) == (expected["kind"], expected["count"])
    assert json.loads(json.dumps([chunk.time_range, chunk.box])) == [expected["time_range"], expected["box"]]
    assert chunk.bounds._asdict() == expected["bounds"]
    recorded = {name: base64.b64decode(text) for name, text in expected["float32"].items()}
    assert {name: array.tobytes() for name, array in chunk.arrays.items()} == recorded


@pytest.mark.parametrize("name", INVALID)
def test_a_damaged_chunk_is_refused_with_byte_and_record(name: str) -> None:
    with pytest.raises(ChunkError) as caught:
        decode_chunk((VECTORS / "invalid" / f"{name}.chunk").read_bytes())
    assert {"byte": caught.value.byte, "record": caught.value.record} == INVALID[name]
    assert "\n" not in str(caught.value)


def entries(data: bytes) -> dict[int, dict[str, Any]]:
    """The reference: the table as docs/format.md has it, one byte at a time."""
    table: dict[int, dict[str, Any]] = {}
    at = 80

    def varint() -> int:
        nonlocal at
        number = shift = 0
        while True:
            at += 1
            number |= (data[at - 1] & 127) << shift
            shift += 7
            if data[at - 1] < 128:
                return number

    for _ in range(data[6]):
        identity, components, bits, transform, planes = data[at : at + 5]
        (step,) = struct.unpack_from("<f", data, at + 5)
        at += 9
        zeros = [z // 2 if z % 2 == 0 else -(z + 1) // 2 for z in (varint() for _ in range(components))]
        lengths = [varint() for _ in range(planes)]
        table[identity] = {"bits": bits, "transform": transform, "step": step, "zeros": zeros, "lengths": lengths}
    for entry in table.values():
        entry["planes"] = []
        for length in entry["lengths"]:
            entry["planes"].append(data[at : at + length])
            at += length
    assert at == len(data) - 4
    return table


def f32(x: float) -> float:
    return struct.unpack("<f", struct.pack("<f", x))[0]


def scalar_values(data: bytes, wanted: int) -> list[list[float]]:
    """The reference: docs/format.md followed word by word, one Python number at a time; rows of values."""
    entry = entries(data)[wanted]
    bits, zeros = entry["bits"], entry["zeros"]
    planes = [zstandard.ZstdDecompressor().decompress(frame) for frame in entry["planes"]]
    rows = range(len(planes[0]))
    if wanted == 1:
        codes, m = [], 0
        for n in rows:
            m += sum(plane[n] << 8 * p for p, plane in enumerate(planes))
            codes.append([sum((m >> 3 * k + axis & 1) << k for k in range(bits)) for axis in range(3)])
    else:
        each = math.ceil(bits / 8)
        codes = [[sum(planes[c * each + p][n] << 8 * p for p in range(each)) for c in range(len(zeros))] for n in rows]
    signed = [[z // 2 if z % 2 == 0 else -(z + 1) // 2 for z in row] for row in codes]
    for n in rows:
        if entry["transform"] == 1:
            before = codes[n - 1] if n else [0] * len(zeros)
            codes[n] = [(x + y) % 2**bits for x, y in zip(before, signed[n], strict=True)]
        if entry["transform"] == 2:
            for c in range(1, len(zeros)):
                codes[n][c] = (codes[n][c - 1] + signed[n][c]) % 2**bits
    values = [[f32((code - zero) * entry["step"]) for code, zero in zip(row, zeros, strict=True)] for row in codes]
    if wanted == 3:
        values = [[f32(math.sqrt(max(0.0, 1 - (x * x + y * y + z * z)))), x, y, z] for x, y, z in values]
    if wanted == 4:
        values = [[f32(x * x * (3 - 2 * x))] for x in (min(1.0, max(0.0, row[0])) for row in values)]
    return values


@pytest.mark.parametrize("name", VALID)
def test_every_attribute_is_what_the_specification_says(name: str) -> None:
    data = (VECTORS / f"{name}.chunk").read_bytes()
    arrays = decode_chunk(data).arrays
    np.testing.assert_array_equal(arrays["log_scales"], scalar_values(data, 2))
    np.testing.assert_array_equal(arrays["opacities"][:, None], scalar_values(data, 4))
    np.testing.assert_array_equal(arrays["rgb"], scalar_values(data, 5))
    if name.startswith("static"):
        np.testing.assert_array_equal(arrays["means"], scalar_values(data, 1))
        np.testing.assert_array_equal(arrays["quats"], scalar_values(data, 3))


@pytest.mark.parametrize("name", [name for name in VALID if name.startswith("dynamic")])
def test_rows_belong_to_the_splats_that_the_form_names_and_are_scaled_by_powers_of_two(name: str) -> None:
    data = (VECTORS / f"{name}.chunk").read_bytes()
    chunk = decode_chunk(data)
    precisions = [row[0] for row in scalar_values(data, 17)]
    exponents = [min(20, max(0, math.floor((p - 1.75) * 0.7213475204444817))) for p in precisions]
    forms = [int(row[0]) for row in scalar_values(data, 18)] if 18 in entries(data) else [0] * chunk.count
    rows = {wanted: iter(scalar_values(data, wanted)) for wanted in range(19, 25) if wanted in entries(data)}
    positions, rotations, centers = (scalar_values(data, wanted) for wanted in (1, 3, 16))
    for n in range(chunk.count):
        motion = [positions[n], *([0.0] * 3 for _ in range(5 if 24 in entries(data) else 3))]
        orders = {order: 18 + order for order in range(1, forms[n] % 4 + 1)}
        for order, wanted in (orders | ({4: 23, 5: 24} if forms[n] & 8 else {})).items():
            motion[order] = [f32(x * 2.0 ** (order * exponents[n])) for x in next(rows[wanted])]
        turning = [f32(x * 2.0 ** exponents[n]) for x in next(rows[22])] if forms[n] & 4 else [0.0] * 4
        assert chunk.arrays["motion"][n].tolist() == motion
        assert chunk.arrays["rotation"][n].tolist() == [rotations[n], turning]
        assert chunk.arrays["time_centers"][n] == f32(centers[n][0] * 2.0 ** -exponents[n])
        assert chunk.arrays["time_log_precisions"][n] == precisions[n]
    assert [next(left, None) for left in rows.values()] == [None] * len(rows)


@pytest.mark.parametrize("name", ["static", "dynamic"])
def test_hundreds_of_damaged_chunks_give_chunk_errors_and_bounded_memory(name: str) -> None:
    data = (VECTORS / f"{name}.chunk").read_bytes()
    rng = np.random.default_rng(0)
    for _ in range(20):
        try_decoder(mutated(data, rng))  # loads modules, uncounted
    tracemalloc.start()
    refused = sum(try_decoder(mutated(data, rng)) is not None for _ in range(600))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert refused > 300
    assert peak < 4 << 20


change = st.tuples(
    st.integers(0, 1 << 16), st.sampled_from(["bit", "byte", "word", "cut", "grow"]), st.binary(max_size=8)
)


@settings(max_examples=200, deadline=None)
@given(name=st.sampled_from(VALID), changes=st.lists(change, min_size=1, max_size=4), seal=st.booleans())
def test_any_damage_is_a_chunk_error_or_finite_numbers(
    name: str, changes: list[tuple[int, str, bytes]], seal: bool
) -> None:
    data = (VECTORS / f"{name}.chunk").read_bytes()
    for at, how, value in changes:
        at %= len(data)
        replaced = {
            "bit": bytes([data[at] ^ 1 << len(value) % 8]),
            "byte": value[:1],
            "word": value[:4],
            "cut": b"",
            "grow": value + data[at : at + 1],
        }[how]
        taken = {"word": len(replaced), "cut": len(value)}.get(how, 1)
        data = data[:at] + replaced + data[at + taken :]
    try_decoder(sealed(data) if seal else data)


@given(st.binary(max_size=300))
def test_any_bytes_are_refused(data: bytes) -> None:
    assert try_decoder(data) is not None


def test_opacities_become_logits_and_those_of_0_and_1_stay_finite() -> None:
    found = logits(np.array([0.0, 0.2, 0.5, 1.0]))
    np.testing.assert_allclose(found, [-math.log(1e6), -math.log(4), 0, math.log(1e6)], rtol=1e-6, atol=1e-7)
    assert found.dtype == np.float32


def test_exponents_of_time_change_where_the_life_halves() -> None:
    """docs/format.md: e is floor((ln s - 1.75) / ln 4), limited; a splat is then seen for about 2^-e."""
    edges = 1.75 + np.log(4) * np.arange(1, 21)
    assert time_exponents((edges + 1e-4).astype(np.float32)).tolist() == list(range(1, 21))
    assert time_exponents((edges - 1e-4).astype(np.float32)).tolist() == list(range(20))
    assert time_exponents(np.float32([-1e30, 1.74, 1e30])).tolist() == [0, 0, 20]
    precisions = np.linspace(2, 29, 500, dtype=np.float32)
    radius = np.sqrt(np.log(255) / np.exp(precisions.astype(np.float64)))
    assert (radius <= 1.02 * 2.0 ** -time_exponents(precisions)).all()
