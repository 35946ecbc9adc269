"""Learned perceptual distance LPIPS v0.1 with AlexNet (Zhang, Isola, Efros, Shechtman and Wang, CVPR 2018)."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn.functional import adaptive_avg_pool2d, conv2d, max_pool2d

from hgs_core.base.errors import InputError

__all__ = ["NETWORK", "SMALLEST_SIDE", "Lpips"]

NETWORK = "AlexNet"
"""The network of the features; another one has other distances."""

SMALLEST_SIDE = 31
"""Pixels: the network's strides leave nothing of a smaller picture."""

_MEAN = (-0.030, -0.088, -0.188)  # channel means of pictures in [-1, 1]: the input scaling of v0.1
_DEVIATION = (0.458, 0.448, 0.450)
_EPSILON = 1e-10  # added to the norm of a pixel's features


@dataclass(frozen=True)
class _Layer:
    """A convolution followed by a ReLU."""

    inputs: int
    outputs: int
    size: int  # side of the kernel, pixels
    stride: int
    padding: int
    pool: bool  # a 3x3 maximum with stride 2 comes before it


_ALEXNET = (
    _Layer(3, 64, 11, 4, 2, pool=False),
    _Layer(64, 192, 5, 1, 2, pool=True),
    _Layer(192, 384, 3, 1, 1, pool=True),
    _Layer(384, 256, 3, 1, 1, pool=False),
    _Layer(256, 256, 3, 1, 1, pool=False),
)


class Lpips:
    """The metric with its weights: 0 for equal pictures, larger for pictures that look less alike."""

    def __init__(self, weights: Path) -> None:
        """Read the weights from an .npz file.

        For i in 0..4 it has the float arrays `AlexNet_0.Conv_i.kernel` [height, width, in, out],
        `AlexNet_0.Conv_i.bias` [out] and `NetLinLayer_i.Conv_0.kernel` [1, 1, out, 1].

        Raises:
            InputError: the file is missing, unreadable, or holds other arrays.
        """
        self._kernels: list[Tensor] = []  # [out, in, height, width]
        self._biases: list[Tensor] = []
        self._linear: list[Tensor] = []  # [out, 1, 1]
        arrays = _Arrays(weights)
        for i, layer in enumerate(_ALEXNET):
            kernel = arrays.read(f"AlexNet_0.Conv_{i}.kernel", (layer.size, layer.size, layer.inputs, layer.outputs))
            self._kernels.append(kernel.permute(3, 2, 0, 1).contiguous())
            self._biases.append(arrays.read(f"AlexNet_0.Conv_{i}.bias", (layer.outputs,)))
            self._linear.append(arrays.read(f"NetLinLayer_{i}.Conv_0.kernel", (1, 1, layer.outputs, 1)).view(-1, 1, 1))

    def __call__(self, image: Tensor, truth: Tensor) -> float | None:
        """Return the distance of two pictures [3, H, W] in [0, 1] (sRGB), or None if a side is below `SMALLEST_SIDE`.

        Equation 1 of the paper: at every layer the features of a pixel are scaled to unit length; the squared
        differences are weighted by channel, averaged over the pixels, and added up over the layers.
        """
        maps = self._distances(image, truth)
        return None if maps is None else float(sum(distances.mean() for distances in maps))

    def with_region(self, image: Tensor, truth: Tensor, region: Tensor) -> tuple[float | None, float | None]:
        """Return the distance of two pictures, and that of the pixels `region` [H, W]: None if there are none.

        For the region, a layer's mean over its pixels is weighted by the share of the region in the part of the picture
        that a pixel of the layer stands for.
        """
        maps = self._distances(image, truth)
        if maps is None:
            return None, None
        whole = float(sum(distances.mean() for distances in maps))
        if not region.any():
            return whole, None
        shares = [adaptive_avg_pool2d(region[None].float(), (d.shape[0], d.shape[1]))[0] for d in maps]
        return whole, float(sum((d * share).sum() / share.sum() for d, share in zip(maps, shares, strict=True)))

    @torch.no_grad()
    def _distances(self, image: Tensor, truth: Tensor) -> list[Tensor] | None:
        """Return the weighted squared differences [rows, columns] of every layer; None for too small a picture."""
        if min(image.shape[1:]) < SMALLEST_SIDE:
            return None
        pair = torch.stack((image, truth)).float() * 2 - 1
        pair = (pair - pair.new_tensor(_MEAN).view(3, 1, 1)) / pair.new_tensor(_DEVIATION).view(3, 1, 1)
        maps = []
        for layer, kernel, bias, linear in zip(_ALEXNET, self._kernels, self._biases, self._linear, strict=True):
            if layer.pool:
                pair = max_pool2d(pair, kernel_size=3, stride=2)
            pair = conv2d(pair, kernel, bias, stride=layer.stride, padding=layer.padding).relu_()
            unit = pair / (pair.square().sum(dim=1, keepdim=True).sqrt() + _EPSILON)
            maps.append(((unit[0] - unit[1]).square() * linear).sum(dim=0))
        return maps


class _Arrays:
    """The arrays of an .npz file of weights."""

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            with path.open("rb") as stream:
                file = np.load(stream, allow_pickle=False)
                if not isinstance(file, np.lib.npyio.NpzFile):
                    raise self._wrong("the file holds a single array")
                self._values: dict[str, npt.NDArray[np.generic]] = {name: file[name] for name in file.files}
        except InputError:
            raise
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise self._wrong(f"unreadable ({error})") from error

    def read(self, name: str, shape: tuple[int, ...]) -> Tensor:
        if name not in self._values:
            raise self._wrong(f"there is no array {name}")
        value = self._values[name]
        if value.shape != shape or not np.issubdtype(value.dtype, np.floating):
            raise self._wrong(f"{name} is {value.dtype} {list(value.shape)}, expected floats {list(shape)}")
        if not np.isfinite(value).all():
            raise self._wrong(f"{name} holds NaN or infinity")
        return torch.from_numpy(value.astype(np.float32))

    def _wrong(self, problem: str) -> InputError:
        return InputError(self._path, problem, "give weights of LPIPS v0.1, AlexNet, as docs/evaluation.md says")
