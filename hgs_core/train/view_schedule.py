"""Which view each iteration trains on: a pure function of seed and iteration, so that resuming needs no state."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

__all__ = ["ViewSchedule"]

_SAMPLE_CAMERAS = 5
_SAMPLE_FRAMES = 8
_INFILL_FRAMES = 3
_BLOCK_PASSES = 20  # passes over all blocks in one training: splats drift between the turns of their block


@dataclass(frozen=True)
class ViewSchedule:
    """Random views, drawn so that the frames in use fit in memory or on disk.

    When all frames of the training cameras fit, every iteration draws a camera and a frame at random. Otherwise the
    capture is cut into blocks of consecutive frames that fit, as long as each other (all cameras of a block together).
    Blocks are visited in a random order that changes with every pass, and iterations draw within the current block: a
    long video is decoded forwards, block by block, instead of being sought all over. Stays are short: while one block
    is looked at, nothing holds splats in place that others need.
    """

    cameras: tuple[int, ...]  # indices into the capture's cameras
    frames: int
    blocks: int  # number of blocks
    stay: int  # iterations for which a block is drawn from
    seed: int

    @staticmethod
    def fitting(
        cameras: tuple[int, ...], frames: int, frame_bytes: int, memory: int, iterations: int, seed: int
    ) -> ViewSchedule:
        """Choose blocks for frames of `frame_bytes` each and `memory` bytes of cache, in a training of `iterations`."""
        fit = max(1, min(frames, memory // max(1, frame_bytes * len(cameras))))
        blocks = -(-frames // fit)
        return ViewSchedule(cameras, frames, blocks, max(1, iterations // (blocks * _BLOCK_PASSES)), seed)

    def view(self, iteration: int) -> tuple[int, int]:
        """Return (camera, frame) of an iteration."""
        random = np.random.default_rng((self.seed, 1, iteration))
        first, last = self.block(iteration)
        return int(random.choice(self.cameras)), int(random.integers(first, last))

    def more_views(self, iteration: int, count: int) -> Iterator[tuple[int, int]]:
        """Yield (camera, frame) of further views, drawn as those of iterations are."""
        random = np.random.default_rng((self.seed, 9, iteration))
        first, last = self.block(iteration)
        for _ in range(count):
            yield int(random.choice(self.cameras)), int(random.integers(first, last))

    def samples(self, iteration: int) -> Iterator[tuple[int, list[int]]]:
        """Yield a few cameras, each with a few frames of the iteration's block, one from each equal part of it."""
        random = np.random.default_rng((self.seed, 4, iteration))
        first, last = self.block(iteration)
        borders = np.linspace(first, last, min(_SAMPLE_FRAMES, last - first) + 1)
        for camera in random.permutation(self.cameras)[:_SAMPLE_CAMERAS]:
            yield int(camera), [int(random.uniform(a, b)) for a, b in pairwise(borders)]

    def everywhere(self, iteration: int) -> Iterator[tuple[int, list[int]]]:
        """Yield all cameras, each with a few frames of the iteration's block."""
        random = np.random.default_rng((self.seed, 7, iteration))
        first, last = self.block(iteration)
        for camera in self.cameras:
            yield camera, [int(frame) for frame in random.integers(first, last, _INFILL_FRAMES)]

    def block(self, iteration: int) -> tuple[int, int]:
        """Return the frames, from the first to before the last, that an iteration draws from."""
        turn, place = divmod(iteration // self.stay, self.blocks)
        block = int(np.random.default_rng((self.seed, 2, turn)).permutation(self.blocks)[place])
        return self.frames * block // self.blocks, self.frames * (block + 1) // self.blocks
