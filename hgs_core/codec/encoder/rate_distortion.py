"""Rate-distortion optimised quantisation: of several codes near a value, the one worth its bits."""

from __future__ import annotations

import itertools

import numpy as np

from hgs_core.base.arrays import Doubles, Whole

__all__ = ["EXCHANGE", "choose", "neighbours"]

# What a bit is worth in squared steps. At a high rate the squared error of a uniform quantiser, step^2 / 12, falls by
# a factor of 4 per bit: its derivative is ln(4) / 12.
EXCHANGE = float(np.log(4) / 12)
CHOICE_ROUNDS = 3  # rounds of choosing codes and counting them again


def neighbours(exact: Doubles) -> Whole:
    """Return the whole numbers within one step of the nearest to `exact` [N, C], all combinations: [N, 3^C, C]."""
    offsets = np.array(list(itertools.product((0, -1, 1), repeat=exact.shape[1])), np.int64)
    return np.rint(exact).astype(np.int64)[:, None] + offsets


def choose(candidates: Whole, cost: Doubles, *, chain: bool = False) -> Whole:
    """Pick one of the candidates [N, K, C] for every row, the first being the plain choice; returns [N, C].

    `cost` [N, K] is the squared error in squared steps. Minimises cost + EXCHANGE * bits, the bits being those of
    an ideal entropy coder for the numbers chosen (with `chain`, for each component's difference from the one
    before), found by repetition.
    """
    symbols = np.concatenate([candidates[..., :1], np.diff(candidates, axis=-1)], axis=-1) if chain else candidates
    symbols = symbols - symbols.min(axis=(0, 1))
    rows = np.arange(len(candidates))
    chosen = np.zeros(len(candidates), np.intp)
    for _ in range(CHOICE_ROUNDS):
        bits = np.zeros(cost.shape)
        for c in range(symbols.shape[-1]):
            counts = np.bincount(symbols[rows, chosen, c], minlength=int(symbols[..., c].max()) + 1) + 0.1
            bits += -np.log2(counts / counts.sum())[symbols[..., c]]
        chosen = np.argmin(cost + EXCHANGE * bits, axis=1)
    return candidates[rows, chosen]
