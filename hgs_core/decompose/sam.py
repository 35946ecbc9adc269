"""Object borders from SAM 2 (Ravi et al., 2024): automatic masks find the motion, the model its borders.

The model runs in the library transformers (extra `sam`) with weights that the user brings: a folder in its format.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn.functional import interpolate

from hgs_core.base.arrays import Mask
from hgs_core.base.errors import InputError
from hgs_core.decompose.components import component_boxes
from hgs_core.decompose.morphology import dilate

__all__ = ["Sam2Refiner"]

_WINDOW_FRAMES = 16  # frames that an object is followed through, from the one in their middle
_MOST_OBJECTS = 6  # objects of a window
_SMALLEST_SHARE = 5e-4  # share of the picture; smaller parts are left to the automatic masks
_BOX_LABELS = (2, 3)  # SAM's prompt labels of a box's upper left and lower right corner
_AGREEMENT_SHARE = 0.5  # share of an object's pixels that the automatic mask must see move
_BORDER_PIXELS = 4  # pixels around an object where its border replaces the automatic one
_MEAN = (0.485, 0.456, 0.406)  # ImageNet mean, sRGB in [0, 1]
_DEVIATION = (0.229, 0.224, 0.225)


class Sam2Refiner:
    """SAM 2 with one set of weights, on the GPU if there is one."""

    def __init__(self, weights: Path) -> None:
        """Load the model.

        Raises:
            InputError: transformers is not installed, or the folder holds no weights of SAM 2 for videos.
        """
        try:
            from transformers import Sam2VideoModel
        except ImportError as error:
            raise InputError("--sam", f"transformers cannot be loaded ({error})", "pip install 'hgs[sam]'") from error
        if not (weights / "config.json").is_file():
            problem = "holds no config.json" if weights.is_dir() else "the folder does not exist"
            raise InputError(weights, problem, "give a folder with SAM 2 weights in the format of transformers")
        self._device = "cuda" if torch.cuda.is_available() else "cpu"
        try:
            self._model: Any = Sam2VideoModel.from_pretrained(weights, local_files_only=True)
        except (OSError, ValueError, RuntimeError, AttributeError) as error:
            raise InputError(weights, f"holds no SAM 2 weights ({error})", "fetch the weights again") from error
        self._model.eval().to(self._device)
        size = self._model.config.image_size
        self._size = int(size if isinstance(size, int) else size[0])  # pixels; the model's pictures are square

    def refine(self, pictures: Sequence[npt.NDArray[np.uint8]], masks: Sequence[Mask]) -> list[Mask]:
        """Return the masks [H, W] of a video's pictures [H, W, 3] with the borders of the objects in them.

        Shadows and small things, which the model does not follow, keep the masks they have.
        """
        refined: list[Mask] = []
        for first in range(0, len(pictures), _WINDOW_FRAMES):
            window = slice(first, first + _WINDOW_FRAMES)
            objects = self._objects(pictures[window], masks[window])
            refined += [_merged(mask, found) for mask, found in zip(masks[window], objects, strict=True)]
        return refined

    @torch.no_grad()
    def _objects(self, pictures: Sequence[npt.NDArray[np.uint8]], masks: Sequence[Mask]) -> list[list[Mask]]:
        """Follow the largest moving parts of the middle frame forwards and backwards; return each frame's objects."""
        from transformers.models.sam2_video.modeling_sam2_video import Sam2VideoInferenceSession

        middle = len(pictures) // 2
        height, width = masks[middle].shape
        boxes = component_boxes(masks[middle], _MOST_OBJECTS, max(1, round(_SMALLEST_SHARE * height * width)))
        found: list[list[Mask]] = [[] for _ in pictures]
        if not boxes:
            return found
        video = torch.cat([self._prepared(picture) for picture in pictures])
        session = Sam2VideoInferenceSession(
            video=video,
            video_height=height,
            video_width=width,
            inference_device=self._device,
            inference_state_device=self._device,
            video_storage_device="cpu",
            dtype=torch.float32,
        )
        scale = torch.tensor([self._size / width, self._size / height])
        for number, (left, top, right, bottom) in enumerate(boxes):
            corners = torch.tensor([[left, top], [right, bottom]]) * scale
            prompt = {"point_coords": corners[None, None], "point_labels": torch.tensor([[_BOX_LABELS]])}
            session.add_point_inputs(session.obj_id_to_idx(number), middle, prompt)
        session.obj_with_new_inputs = list(range(len(boxes)))
        self._model(inference_session=session, frame_idx=middle)
        for backwards in (False, True):
            follow = self._model.propagate_in_video_iterator(session, start_frame_idx=middle, reverse=backwards)
            for output in follow:
                if not (backwards and output.frame_idx == middle):
                    logits = interpolate(output.pred_masks.float(), (height, width), mode="bilinear")
                    found[output.frame_idx] = list((logits[:, 0] > 0).cpu().numpy())
        return found

    def _prepared(self, picture: npt.NDArray[np.uint8]) -> Tensor:
        """Return a picture as the model takes it, [1, 3, size, size]."""
        planes = torch.from_numpy(np.ascontiguousarray(picture.transpose(2, 0, 1))).float()[None] / 255
        square = interpolate(planes, (self._size, self._size), mode="bilinear", antialias=True)
        return (square - torch.tensor(_MEAN)[:, None, None]) / torch.tensor(_DEVIATION)[:, None, None]


def _merged(mask: Mask, objects: Sequence[Mask]) -> Mask:
    """Return a mask with the borders of those objects that it says move, and its own elsewhere."""
    moving = np.zeros_like(mask)
    for found in objects:
        if found.any() and mask[found].mean() >= _AGREEMENT_SHARE:
            moving |= found
    return np.asarray(moving | (mask & ~dilate(moving, _BORDER_PIXELS)), bool)
