"""Static and dynamic splats and the hybrid scene made of them.

The containers are generic over the array type: numpy on disk and in the codec, torch in rendering and training.
`map` converts between them. Quaternions are w, x, y, z and need not be normalised; colours are display-referred
sRGB in [0, 1]; opacities are stored as logits and scales as natural logarithms, so that every float is valid.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Self, TypeVar, cast

import numpy as np
import numpy.typing as npt

from hgs_core.scene.motion import COEFFICIENTS

__all__ = ["DynamicSplats", "HybridScene", "Segment", "StaticSplats", "joined"]

A = TypeVar("A")
B = TypeVar("B")


class _Arrays(Generic[A]):
    """A struct of arrays with one row per splat."""

    def items(self) -> Iterator[tuple[str, A]]:
        """Yield (field name, array) in declaration order."""
        for field in dataclasses.fields(cast(Any, self)):
            yield field.name, getattr(self, field.name)

    def __len__(self) -> int:
        """Return the number of splats."""
        return int(next(self.items())[1].shape[0])  # type: ignore[attr-defined]

    def take(self, index: Any) -> Self:
        """Return the rows that `index` (mask, slice or indices) selects, as the same kind of container."""
        return type(self)(*(array[index] for _, array in self.items()))  # type: ignore[index]


@dataclass(frozen=True)
class StaticSplats(_Arrays[A]):
    """N splats that never change: 14 floats each, nothing temporal."""

    means: A  # [N, 3] world units
    log_scales: A  # [N, 3] ln of the standard deviations along the splat's axes, world units
    quats: A  # [N, 4] w, x, y, z; zero is treated as the identity
    opacity_logits: A  # [N]
    rgb: A  # [N, 3]

    def map(self, convert: Callable[[A], B]) -> StaticSplats[B]:
        """Apply `convert` to every array."""
        return StaticSplats(*(convert(array) for _, array in self.items()))

    @staticmethod
    def empty() -> StaticSplats[npt.NDArray[np.float32]]:
        """Return a set of no splats (numpy, float32)."""
        return StaticSplats(*(np.zeros((0, *s), np.float32) for s in ((3,), (3,), (4,), (), (3,))))


@dataclass(frozen=True)
class DynamicSplats(_Arrays[A]):
    """M splats that move, turn, appear and vanish: 29 floats each, 35 with motion of the fifth order.

    At normalised time t in [0, 1] of its segment, with d = t - time_centers and s = exp(time_log_precisions):
    position sum_k motion[k] d^k, rotation normalise(rotation[0] + d rotation[1]), opacity
    sigmoid(opacity_logits) exp(-s d^2).
    """

    motion: A  # [M, K, 3] polynomial coefficients in d, constant first, world units; K = 4 or 6 (scene/motion.py)
    rotation: A  # [M, 2, 4] quaternion polynomial in d, w, x, y, z
    log_scales: A  # [M, 3]
    opacity_logits: A  # [M] of the peak opacity sigma, at d = 0
    time_centers: A  # [M] mu, normalised time; may lie outside [0, 1]
    time_log_precisions: A  # [M] ln s, s in 1 / normalised time^2
    rgb: A  # [M, 3]

    def map(self, convert: Callable[[A], B]) -> DynamicSplats[B]:
        """Apply `convert` to every array."""
        return DynamicSplats(*(convert(array) for _, array in self.items()))

    @staticmethod
    def empty(coefficients: int = COEFFICIENTS[0]) -> DynamicSplats[npt.NDArray[np.float32]]:
        """Return a set of no splats (numpy, float32) with so many coefficients of motion."""
        shapes = ((coefficients, 3), (2, 4), (3,), (), (), (), (3,))
        return DynamicSplats(*(np.zeros((0, *s), np.float32) for s in shapes))


@dataclass(frozen=True)
class Segment(Generic[A]):
    """The dynamic splats of one stretch of time; [start, end] in seconds of the capture's clock.

    Normalised time is t = (seconds - start) / (end - start); a segment of no length has t = 0.
    """

    start: float
    end: float
    dynamic: DynamicSplats[A]

    def normalised(self, seconds: float) -> float:
        """Return the segment's time t of a moment in seconds."""
        return (seconds - self.start) / (self.end - self.start) if self.end > self.start else 0.0


@dataclass(frozen=True)
class HybridScene(Generic[A]):
    """One static set shared by all time, and one dynamic set per segment, in order of time.

    With them goes how they must be drawn to look as they were trained.
    """

    static: StaticSplats[A]
    segments: tuple[Segment[A], ...]
    background: tuple[float, float, float] = (0.0, 0.0, 0.0)  # sRGB in [0, 1]
    antialiased: bool = False  # otherwise splats that are thinner than a pixel show too strong, or too weak

    @property
    def start(self) -> float:
        """First moment, seconds."""
        return self.segments[0].start

    @property
    def end(self) -> float:
        """Last moment, seconds."""
        return self.segments[-1].end

    @property
    def dynamic_splats(self) -> int:
        """How many dynamic splats all segments have together."""
        return sum(len(segment.dynamic) for segment in self.segments)

    def segment_at(self, seconds: float) -> Segment[A]:
        """Return the segment that is shown at `seconds`: the last that has started, or the first."""
        for segment in reversed(self.segments):
            if seconds >= segment.start:
                return segment
        return self.segments[0]

    def map(self, convert: Callable[[A], B]) -> HybridScene[B]:
        """Apply `convert` to every array."""
        return HybridScene(
            self.static.map(convert),
            tuple(Segment(s.start, s.end, s.dynamic.map(convert)) for s in self.segments),
            self.background,
            self.antialiased,
        )


S = TypeVar("S", StaticSplats[npt.NDArray[np.float32]], DynamicSplats[npt.NDArray[np.float32]])


def joined(sets: Sequence[S]) -> S:
    """Return the splats of all sets, at least one, in order; dynamic ones with the most coefficients among them."""
    columns = zip(*([array for _, array in splats.items()] for splats in sets), strict=True)
    return type(sets[0])(*(np.concatenate(_alike(column)) for column in columns))


def _alike(column: Sequence[npt.NDArray[np.float32]]) -> list[npt.NDArray[np.float32]]:
    """Give polynomials of fewer coefficients higher ones of zero; other arrays are alike already."""
    most = max(array.shape[1:2] for array in column)
    return [
        array
        if array.shape[1:2] == most
        else np.pad(array, ((0, 0), (0, most[0] - array.shape[1]), *((0, 0),) * (array.ndim - 2)))
        for array in column
    ]
