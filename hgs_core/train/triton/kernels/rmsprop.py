"""One step of RMSprop, fused."""

import triton
import triton.language as tl

__all__ = ["rmsprop"]


@triton.jit
def rmsprop(
    parameters,
    gradients,
    moments,
    factors,
    rows,
    decays,
    rate,
    inverse_root,
    count,
    SPAN: tl.constexpr,
    WIDTH: tl.constexpr,
    BETA: tl.constexpr,
    EPSILON: tl.constexpr,
    BLOCK: tl.constexpr,
):
    """p -= rate g / (inverse_root sqrt(v) + eps): the bias correction lies in `inverse_root`.

    Gradients are of rows of WIDTH values: of all, or of those that `rows` names. Factors of the rate, if any, are for
    SPAN values each; decays of the moments, if any, for a row each.
    """
    i = tl.program_id(0).to(tl.int64) * BLOCK + tl.arange(0, BLOCK)
    mask = i < count
    row = i // WIDTH
    at = i
    if rows is not None:
        at = tl.load(rows + row, mask=mask, other=0) * WIDTH + i % WIDTH
    g = tl.load(gradients + i, mask=mask, other=0.0)
    v = tl.load(moments + at, mask=mask, other=0.0)
    left = BETA
    if decays is not None:
        left = tl.load(decays + row, mask=mask, other=0.0)
    v = v * left + g * g * (1.0 - BETA)
    tl.store(moments + at, v, mask=mask)
    if factors is not None:
        g = g * tl.load(factors + i // SPAN, mask=mask, other=0.0)
    p = tl.load(parameters + at, mask=mask, other=0.0)
    tl.store(parameters + at, p - g * rate / (tl.sqrt(v) * inverse_root + EPSILON), mask=mask)
