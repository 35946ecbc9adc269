"""The loss of an encoding on some views, in whole pictures and in moving pixels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.fit.encoding_views import EncodeViews
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.threads import one_torch_thread
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["Decibels", "Loss"]

LOSS_VIEWS = 12  # views of the measurement, in each of several groups of cameras
GOLDEN_RATIO = 0.618  # fractional parts of its multiples spread evenly
IMPORTED_ERROR = 1e-3  # mean squared error (30 dB) that a scene is taken to have where no picture tells


@dataclass(frozen=True)
class Decibels:
    """The loss of views in PSNR, dB; negative for a gain."""

    whole: float  # the mean over views of what each loses, of all its pixels; of groups of views the largest
    moving: float | None  # loss of the moving pixels of all views; None: motion unknown or absent

    @property
    def most(self) -> float:
        """The larger one, compared with a budget."""
        return self.whole if self.moving is None else max(self.whole, self.moving)

    def without_gain(self, gained: Decibels) -> Decibels:
        """Return the loss against a scene that loses `gained` itself, where it is the better one."""
        moving = None if self.moving is None else self.moving - min(0.0, gained.moving or 0.0)
        return Decibels(self.whole - min(0.0, gained.whole), moving)


class Loss:
    """The loss of quantisation on some views.

    Without pictures to compare with, the scene itself is taken to be wrong by `IMPORTED_ERROR`, to which the changes
    add; it may then stand before anything, so that the loss is the larger one of those on black and on white. Where
    made-up cameras see different things, from afar and from near, it is that of the group that loses most.
    """

    @one_torch_thread()
    def __init__(self, scene: HybridScene[Floats], views: EncodeViews, cameras: Mapping[int, Camera]) -> None:
        """Draw `scene` in views spread over `cameras` (by index) and all time, as the reference of losses.

        Where something moves is known of trained cameras alone.

        Raises:
            InputError: a frame or a mask cannot be read.
        """
        self._cameras, self._times, self._moment = cameras, views.times, views.moment
        groups = [[i for i in group if i in cameras] for group in views.groups] or [sorted(cameras)]
        self._groups = [slice(number * LOSS_VIEWS, (number + 1) * LOSS_VIEWS) for number in range(len(groups))]
        self._views = [
            (indices[i * len(indices) // LOSS_VIEWS], int(i * GOLDEN_RATIO % 1 * len(views.times)))
            for indices in groups
            for i in range(LOSS_VIEWS)
        ]
        self._backgrounds = (0.0, 1.0) if views.any_background else (0.0,)
        own = self._pictures(scene)
        self._reference = own if views.truth is None else [torch.stack([views.truth(*view)]) for view in self._views]
        self._least = IMPORTED_ERROR if views.truth is None else 1e-12
        self._moving: list[Tensor] = []
        if views.moving is not None and set(cameras) <= set(views.trained):
            self._moving = [views.moving(*view) for view in self._views]
        self._psnr, self._psnr_moving = self._whole(own), self._of_moving(own)

    @one_torch_thread()
    def of(self, scene: HybridScene[Floats]) -> Decibels:
        """Return by how much `scene` is worse than the one given first."""
        pictures = self._pictures(scene)
        whole, moving = float((self._psnr - self._whole(pictures)).max()), self._of_moving(pictures)
        return Decibels(whole, None if moving is None or self._psnr_moving is None else self._psnr_moving - moving)

    def _whole(self, pictures: Sequence[Tensor]) -> Doubles:
        """Return the mean PSNR of each group of views on each background, [G, B]."""
        pairs = zip(pictures, self._reference, strict=True)
        errors = np.array([((picture - true) ** 2).mean(dim=(1, 2, 3)).double().numpy() for picture, true in pairs])
        decibels = -10 * np.log10(errors + self._least)
        return np.stack([decibels[group].mean(axis=0) for group in self._groups])

    def _of_moving(self, pictures: Sequence[Tensor]) -> float | None:
        """Return the PSNR of all moving pixels together: views in which little moves would count too much in a mean."""
        count = sum(int(mask.sum()) for mask in self._moving)
        if count == 0:
            return None
        error = 0.0
        for picture, true, mask in zip(pictures, self._reference, self._moving, strict=True):
            error += float(((picture - true) ** 2)[:, :, mask].double().sum())
        return float(-10 * np.log10(error / (3 * count) + self._least))

    def _pictures(self, scene: HybridScene[Floats]) -> list[Tensor]:
        """Draw each view on each background: [B, 3, H, W]."""
        tensors = scene.map(torch.from_numpy)
        pictures = []
        for index, frame in self._views:
            segment = tensors.segment_at(float(self._times[frame]))
            view = FixedView(tensors.static, self._cameras[index], antialiased=scene.antialiased)
            drawn = view.frame(segment.dynamic, segment.normalised(self._moment(index, frame)))
            grounds = [drawn.rgb + (1 - drawn.alpha) * value if value else drawn.rgb for value in self._backgrounds]
            pictures.append(torch.stack(grounds).clamp(0, 1))
        return pictures
