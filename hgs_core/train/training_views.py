"""The training views of a segment: pictures of the training cameras, sized, timed and masked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.base.cores import core_pool
from hgs_core.base.progress import ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import reduced_mask, reduced_picture
from hgs_core.decompose.background import sample_frames
from hgs_core.decompose.masks import MotionMasks
from hgs_core.points.same_moment import same_moments
from hgs_core.render.types import WHOLE, Window
from hgs_core.scene.camera import Camera
from hgs_core.train.device_frames import DeviceFrames
from hgs_core.train.moving_tiles import MovingTiles, tiles_of
from hgs_core.train.segment_cuts import CaptureSegment
from hgs_core.train.time_shifts import TimeShifts
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.view_schedule import ViewSchedule

__all__ = ["Instant", "TrainingView", "TrainingViews"]

_CPU = torch.device("cpu")
_READ_AHEAD = 2  # iterations
_SAMPLE_SIZE = 0.5  # scale of the pictures for labels and contributions


@dataclass(frozen=True)
class TrainingView:
    """The training view of one step."""

    place: int  # place of the camera among the training cameras
    camera: Camera  # camera at the drawn size
    moment: float  # normalised time
    target: Tensor  # [3, H, W]; of a step where it moves its window alone
    moving: Tensor | None = None  # [H, W], or of the window, pixels that move; None unless requested


@dataclass(frozen=True)
class Instant:
    """One moment of C training cameras, all at one size: of all of them, if they are in step."""

    seconds: float
    moment: float  # normalised time
    places: tuple[int, ...]  # places of the cameras among the training cameras
    cameras: list[Camera]  # C, at the pictures' size
    pictures: list[npt.NDArray[np.uint8]]  # C times [H, W, 3]
    moving: list[npt.NDArray[np.bool_]]  # C times [H, W]


class TrainingViews:
    """The views of one segment; other cameras than those to train with are never read."""

    def __init__(
        self,
        capture: Capture,
        cameras: Mapping[int, Camera],  # index in the capture -> training camera, with its near plane
        config: TrainConfig,
        segment: CaptureSegment,
        masks: MotionMasks | None,
        seed: int,
        device: torch.device = _CPU,  # place of the pictures and masks of `of_iteration`
    ) -> None:
        self._capture, self._all, self._config, self._segment = capture, cameras, config, segment
        self._masks = masks
        self._frames = DeviceFrames(capture, device, capture.cache_bytes)
        self._on_host = DeviceFrames(capture, _CPU, 0)
        self._training = tuple(cameras)
        self._places = {camera: place for place, camera in enumerate(self._training)}
        self.cameras = tuple(cameras.values())
        self._tiles: dict[tuple[int, int, float], MovingTiles | None] = {}
        frame_bytes = max(3 * camera.width * camera.height for camera in self.cameras)
        self.order = ViewSchedule.fitting(
            self._training, segment.frames, frame_bytes, capture.room, config.iterations, seed
        )
        self._block: tuple[int, int] | None = None
        self.time_shifts: TimeShifts | None = None
        """Learned shifts of the cameras' clocks, by which single views are late; None: there are none."""

    @property
    def masked(self) -> bool:
        """Whether motion masks are known."""
        return self._masks is not None

    def moving(self, frame: int) -> list[npt.NDArray[np.bool_]]:
        """Return the motion masks [H, W] of all training cameras for a frame of the segment; there must be masks."""
        assert self._masks is not None
        return [self._masks.mask(index, self._segment.first + frame) for index in self._training]

    def hold(self, iteration: int, progress: ProgressCallback) -> None:
        """Have the pictures of an iteration's block at hand, and that of a later one on its way.

        Progress is reported where a block is entered.

        Raises:
            InputError: a picture is unreadable, or the disk is full.
            StageStopped: the callback wishes so.
        """
        block = self.order.block(iteration)
        if block != self._block:
            first, last = (self._segment.first + frame for frame in block)
            self._capture.hold(self._training, range(first, last), progress)
            self._block = block
        ahead = map(self.order.view, (iteration + _READ_AHEAD,))  # not drawn where nothing is on disk
        self._capture.expect((camera, self._segment.first + frame) for camera, frame in ahead)

    def of_iteration(self, iteration: int, size: float, *, masked: bool = False) -> TrainingView:
        """Return the view of an iteration, resized by the factor `size`; `masked`: with the mask of its movers."""
        index, frame = self.order.view(iteration)
        return self._view(self._frames, index, frame, size, masked=masked)

    def where_it_moves(self, iteration: int, count: int, size: float) -> Iterator[tuple[TrainingView, MovingTiles]]:
        """Yield views in which something moves, resized by the factor `size`, with the targets of its windows alone.

        `count` views are drawn; those in which nothing moves are left out. There must be masks.
        """
        for index, frame in self.order.more_views(iteration, count):
            tiles = self._moving_tiles(index, frame, size)
            if tiles is not None:
                yield self._view(self._frames, index, frame, size, window=tiles.window), tiles

    def silhouettes(self, iteration: int, more: int, size: float) -> Iterator[tuple[TrainingView, MovingTiles]]:
        """Yield the view of an iteration and `more` others, as `where_it_moves` does, with the masks of the windows."""
        for index, frame in (self.order.view(iteration), *self.order.more_views(iteration, more)):
            tiles = self._moving_tiles(index, frame, size)
            if tiles is not None:
                yield self._view(self._frames, index, frame, size, masked=True, window=tiles.window), tiles

    def _moving_tiles(self, index: int, frame: int, size: float) -> MovingTiles | None:
        key = index, frame, size
        if key not in self._tiles:
            assert self._masks is not None
            camera = self._sized(index, size)
            self._tiles[key] = tiles_of(reduced_mask(self._masks.mask(index, self._segment.first + frame), camera))
        return self._tiles[key]

    def samples(self, iteration: int) -> Iterator[Iterator[TrainingView]]:
        """Yield views of a few cameras at a few moments, at half size, for the judgement of labels.

        Here and in `everywhere`, the pictures are read as a camera's views are asked for, which several threads may do.
        """
        for index, frames in self.order.samples(iteration):
            yield self._views(index, frames, _SAMPLE_SIZE)

    def everywhere(self, iteration: int, size: float) -> Iterator[Iterator[TrainingView]]:
        """Yield, for every training camera, views at a few moments, with motion masks if they are known.

        Pictures and masks are resized by the factor `size`.
        """
        for index, frames in self.order.everywhere(iteration):
            yield self._views(index, frames, size, masked=self.masked)

    def poses(self, moments: int) -> Iterator[tuple[Camera, list[float]]]:
        """Yield every training camera, at half size, with every second of at most `moments` normalised times.

        Neighbours in the list take turns: what a camera misses the next one sees.
        """
        frames = sample_frames(self._segment.frames, moments)
        times = self._capture.times[[self._segment.first + frame for frame in frames]]
        normalised = [self._segment.clock.normalised(float(seconds)) for seconds in times]
        for place, camera in enumerate(self.cameras):
            yield camera.scaled(_SAMPLE_SIZE), normalised[place % 2 :: 2] or normalised

    def instants(self, count: int, size: float, generator: np.random.Generator) -> Iterator[Instant]:
        """Yield at most `count` moments, evenly over the segment from a random first one; there must be masks.

        Pictures and masks are resized by the factor `size`.

        Of cameras that are not in step each moment has one group of those that are, another every time.
        """
        assert self._masks is not None
        every = -(-self._segment.frames // count)
        for turn, frame in enumerate(range(int(generator.integers(every)), self._segment.frames, every)):
            groups = same_moments(self._capture, self._training, self._segment.first + frame)
            group = groups[turn % len(groups)]
            cameras = [self._sized(index, size) for index in group.cameras]
            with core_pool() as pool:
                pictures = list(pool.map(self._capture.frame, group.cameras, group.frames))
                pictures = list(pool.map(reduced_picture, pictures, cameras))
                moving = list(pool.map(self._masks.mask, group.cameras, group.frames))
                moving = list(pool.map(reduced_mask, moving, cameras))
            places = tuple(self._places[index] for index in group.cameras)
            moment = self._segment.clock.normalised(group.seconds)
            yield Instant(group.seconds, moment, places, cameras, pictures, moving)

    def _sized(self, index: int, size: float) -> Camera:
        return self._all[index] if size == 1.0 else self._all[index].scaled(size)

    def _views(self, index: int, frames: Sequence[int], size: float, *, masked: bool = False) -> Iterator[TrainingView]:
        for frame in frames:
            yield self._view(self._on_host, index, frame, size, masked)

    def _view(
        self, frames: DeviceFrames, index: int, frame: int, size: float, masked: bool = False, window: Window = WHOLE
    ) -> TrainingView:
        frame += self._segment.first
        camera = self._sized(index, size)
        target = frames.target(index, frame, camera, window)
        late = 0.0 if self.time_shifts is None else self.time_shifts.of(self._places[index])
        moment = self._segment.clock.normalised(self._capture.moment(index, frame) + late)
        moving = None
        if masked:
            assert self._masks is not None, "separate stages need masks"
            moving = torch.from_numpy(np.array(reduced_mask(self._masks.mask(index, frame), camera)[window])).to(
                target.device
            )
        return TrainingView(self._places[index], camera, moment, target, moving)
