"""Damage chunks and manifests at random and see that the decoders refuse them as they must.

    .venv/bin/python scripts/fuzz_codec.py --count 100000 --seed 1

A decoder must answer every input with a ChunkError (of a manifest: an InputError) or with finite numbers, and take no
more memory than the number of splats in the file allows. Anything else is printed with the seed of the input, and the
exit status is 1. The inputs are the same for the same seed and count, however many processes share the work.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import resource
import struct
import sys
import time
import traceback
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.codec import ChunkError, decode_chunk
from hgs_core.codec.format.manifest_reading import read_manifest

VECTORS = Path(__file__).resolve().parent.parent / "tests" / "vectors"
HEADER = 80
LENGTH_AT = 16
BATCH = 2000
MANIFEST_SHARE = 0.1
LARGEST_GROWTH = 512 << 20  # bytes by which a process may grow: a chunk of 2^20 splats, once
TELLING = (0, 1, 2, 127, 128, 255, 256, 2**15, 2**16, 2**20, 2**24, 2**28, 2**31 - 1, 2**31, 2**32 - 1)


def sealed(data: bytes) -> bytes:
    """Make the checksum right again, so that the fault behind it is met."""
    return data[:-4] + struct.pack("<I", zlib.crc32(data[:-4]))


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """Damage a chunk in one to three places; mostly, length and checksum then agree with the bytes again."""
    changed = bytearray(data)
    for _ in range(rng.integers(1, 4)):
        if len(changed) < HEADER:
            break
        # Header and table are a small part of a chunk and most of what a decoder trusts.
        reach = min(len(changed), HEADER + 150) if rng.random() < 0.6 else len(changed)
        at = int(rng.integers(reach))
        how = rng.integers(5)
        if how == 0:
            changed[at] ^= 1 << int(rng.integers(8))
        elif how == 1:
            changed[at] = int(rng.integers(256))
        elif how == 2:
            value = TELLING[rng.integers(len(TELLING))]
            size = int(rng.choice([1, 2, 4]))
            changed[at : at + size] = (value % 256**size).to_bytes(size, "little")
        elif how == 3:
            changed[at : at + int(rng.integers(40))] = rng.bytes(int(rng.integers(40)))
        else:
            other = int(rng.integers(reach))
            changed[at : at + 9] = changed[other : other + 9]
    if len(changed) >= HEADER and rng.random() < 0.95:
        struct.pack_into("<I", changed, LENGTH_AT, len(changed))
        return sealed(bytes(changed))
    return bytes(changed)


def try_decoder(data: bytes) -> ChunkError | None:
    """Return the error that the decoder gives; any other exception, and numbers that are not finite, escape."""
    try:
        chunk = decode_chunk(data)
    except ChunkError as error:
        return error
    if not all(np.isfinite(array).all() for array in chunk.arrays.values()):
        raise AssertionError("decoded numbers are not finite")
    return None


def mutated_document(text: str, rng: np.random.Generator) -> Any:
    """Put something else in the place of one value of a JSON document."""
    changed = json.loads(text)
    node = changed
    while True:
        key = rng.choice(list(node)) if isinstance(node, dict) else int(rng.integers(len(node)))
        inside = node[key]
        if isinstance(inside, dict | list) and inside and rng.random() < 0.8:
            node = inside
            continue
        odd = [None, True, -1, 0, 1e308, 2**70, 0.5, "", "x" * 64, [], {}, [[]], float("nan"), inside]
        node[key] = odd[rng.integers(len(odd))]
        if rng.random() < 0.1 and isinstance(node, dict):
            del node[key]
        return changed


def try_manifest(document: Any) -> InputError | None:
    """Return the error that reading the manifest gives."""
    try:
        read_manifest(document)
    except InputError as error:
        return error
    return None


def run_batch(task: tuple[int, int, int]) -> tuple[int, int, list[str]]:
    """Try `count` inputs; return the numbers of tried and refused ones, and the faults."""
    seed, batch, count = task
    chunks = [file.read_bytes() for file in sorted(VECTORS.glob("*.chunk"))]
    document = (VECTORS / "manifest.json").read_text()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    refused = 0
    faults: list[str] = []
    for i in range(count):
        rng = np.random.default_rng((seed, batch, i))
        try:
            if rng.random() < MANIFEST_SHARE:
                error: InputError | None = try_manifest(mutated_document(document, rng))
            else:
                error = try_decoder(mutated(chunks[rng.integers(len(chunks))], rng))
            refused += error is not None
        except Exception:
            faults.append(f"seed {seed}, batch {batch}, input {i}:\n{traceback.format_exc()}")
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    if grown > LARGEST_GROWTH:
        faults.append(f"seed {seed}, batch {batch}: memory grew by {grown} bytes")
    return count, refused, faults


def main() -> int:
    parser = argparse.ArgumentParser(description="Damage chunks and manifests at random and decode them.")
    parser.add_argument("--count", type=int, default=100_000, metavar="N", help="inputs to try (default: 100000)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the inputs (default: 0)")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, metavar="N", help="default: all cores")
    options = parser.parse_args()
    tasks = [
        (options.seed, i, min(BATCH, options.count - start)) for i, start in enumerate(range(0, options.count, BATCH))
    ]
    began = time.monotonic()
    tried = refused = failed = 0
    with multiprocessing.Pool(options.processes) as pool:
        for count, no, faults in pool.imap_unordered(run_batch, tasks):
            tried, refused, failed = tried + count, refused + no, failed + len(faults)
            for fault in faults:
                print(fault, file=sys.stderr)
    seconds = time.monotonic() - began
    print(f"{tried} inputs, {refused} refused, {failed} faults, {seconds:.1f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
