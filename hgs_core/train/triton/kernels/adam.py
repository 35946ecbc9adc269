"""One step of Adam, fused."""

import triton
import triton.language as tl

__all__ = ["adam"]


@triton.jit
def adam(
    parameters, gradients, first_moments, second_moments, factors, rate, inverse_root, count,
    SPAN: tl.constexpr, BETA1: tl.constexpr, BETA2: tl.constexpr, EPSILON: tl.constexpr, BLOCK: tl.constexpr,
):  # fmt: skip
    """p -= rate m / (inverse_root sqrt(v) + eps): both bias corrections lie in `rate` and `inverse_root`.

    Factors of the rate, if any, are for SPAN values each.
    """
    i = tl.program_id(0).to(tl.int64) * BLOCK + tl.arange(0, BLOCK)
    mask = i < count
    g = tl.load(gradients + i, mask=mask, other=0.0)
    m = tl.load(first_moments + i, mask=mask, other=0.0) * BETA1 + g * (1.0 - BETA1)
    v = tl.load(second_moments + i, mask=mask, other=0.0) * BETA2 + g * g * (1.0 - BETA2)
    tl.store(first_moments + i, m, mask=mask)
    tl.store(second_moments + i, v, mask=mask)
    p = tl.load(parameters + i, mask=mask, other=0.0)
    if factors is not None:
        m = m * tl.load(factors + i // SPAN, mask=mask, other=0.0)
    step = m * rate / (tl.sqrt(v) * inverse_root + EPSILON)
    tl.store(parameters + i, p - step, mask=mask)
