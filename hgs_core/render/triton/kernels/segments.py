"""Sums over the tiles of a splat, in an order that never changes: no atomics."""

import triton
import triton.language as tl

__all__ = ["reduce_slots"]


@triton.jit
def reduce_slots(
    slots,
    first_slots,
    counts,
    totals,
    rows,
    WIDTH: tl.constexpr,
    MAXIMA: tl.constexpr,
    ROWS: tl.constexpr,
    LANES: tl.constexpr,
    COLUMNS: tl.constexpr,
):
    """The sums, or of the last MAXIMA columns the maxima, of every row's `counts` consecutive slots [.., WIDTH].

    A program has ROWS rows and reads LANES slots of each at a time. COLUMNS: a power of two from WIDTH. No value whose
    maximum is wanted may be negative.
    """
    row = tl.program_id(0) * ROWS + tl.arange(0, ROWS)
    mask = row < rows
    first = tl.load(first_slots + row, mask=mask, other=0).to(tl.int64)
    count = tl.load(counts + row, mask=mask, other=0)
    lane = tl.arange(0, LANES)
    column = tl.arange(0, COLUMNS)
    total = tl.zeros((ROWS, LANES, COLUMNS), tl.float32)
    for start in range(0, tl.max(count, axis=0), LANES):
        k = start + lane
        inside = (k[None, :] < count[:, None])[:, :, None] & (column < WIDTH)[None, None, :]
        at = (first[:, None] + k[None, :])[:, :, None] * WIDTH + column[None, None, :]
        values = tl.load(slots + at, mask=inside, other=0.0)
        if MAXIMA > 0:
            total = tl.where((column >= WIDTH - MAXIMA)[None, None, :], tl.maximum(total, values), total + values)
        else:
            total += values
    result = tl.sum(total, axis=1)
    if MAXIMA > 0:
        result = tl.where((column >= WIDTH - MAXIMA)[None, :], tl.max(total, axis=1), result)
    at = row[:, None] * WIDTH + column[None, :]
    tl.store(totals + at, result, mask=mask[:, None] & (column < WIDTH)[None, :])
