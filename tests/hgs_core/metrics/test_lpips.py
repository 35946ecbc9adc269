"""LPIPS against the network written out with numpy windows, and against the authors' package."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.metrics.lpips import Lpips
from tests.hgs_core.evaluate.pictures import wave_pair

Array = npt.NDArray[np.float64]
KERNELS = ((11, 3, 64), (5, 64, 192), (3, 192, 384), (3, 384, 256), (3, 256, 256))  # side, in, out


@pytest.fixture(scope="module")
def weights() -> dict[str, npt.NDArray[np.float32]]:
    r = np.random.default_rng(0)
    arrays = {}
    for i, (side, inputs, outputs) in enumerate(KERNELS):
        kernel = r.normal(size=(side, side, inputs, outputs)) / (side * np.sqrt(inputs))
        arrays[f"AlexNet_0.Conv_{i}.kernel"] = kernel.astype(np.float32)
        arrays[f"AlexNet_0.Conv_{i}.bias"] = r.normal(0, 0.1, outputs).astype(np.float32)
        arrays[f"NetLinLayer_{i}.Conv_0.kernel"] = r.uniform(0, 1, (1, 1, outputs, 1)).astype(np.float32)
    return arrays


@pytest.fixture(scope="module")
def file(weights: dict[str, npt.NDArray[np.float32]], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lpips") / "weights.npz"
    np.savez(path, **weights)  # type: ignore[arg-type]
    return path


def windows(picture: Array, side: int, stride: int) -> Array:
    """Return [rows, columns, channels, side, side] of a picture [H, W, C]."""
    return np.lib.stride_tricks.sliding_window_view(picture, (side, side), axis=(0, 1))[::stride, ::stride]


def features(picture: Array, weights: dict[str, npt.NDArray[np.float32]]) -> list[Array]:
    """The outputs [rows, columns, channels] of AlexNet's five convolutions for a picture [3, H, W] in [0, 1]."""
    x = (2 * picture.transpose(1, 2, 0) - 1 - np.array([-0.030, -0.088, -0.188])) / np.array([0.458, 0.448, 0.450])
    outputs = []
    for i, (stride, padding) in enumerate(((4, 2), (1, 2), (1, 1), (1, 1), (1, 1))):
        if i in (1, 2):
            x = windows(x, 3, 2).max(axis=(3, 4))
        kernel = weights[f"AlexNet_0.Conv_{i}.kernel"].astype(np.float64)
        padded = np.pad(x, ((padding, padding), (padding, padding), (0, 0)))
        x = np.einsum("rcikl,klio->rco", windows(padded, len(kernel), stride), kernel, optimize=True)
        x = np.maximum(x + weights[f"AlexNet_0.Conv_{i}.bias"], 0)
        outputs.append(x)
    return outputs


def reference(a: Array, b: Array, weights: dict[str, npt.NDArray[np.float32]]) -> float:
    """Zhang et al., 2018, equation 1."""
    total = 0.0
    for i, (x, y) in enumerate(zip(features(a, weights), features(b, weights), strict=True)):
        x, y = (f / (np.linalg.norm(f, axis=2, keepdims=True) + 1e-10) for f in (x, y))
        total += ((x - y) ** 2 @ weights[f"NetLinLayer_{i}.Conv_0.kernel"].ravel()).mean()
    return total


@pytest.mark.parametrize("size", [(31, 31), (50, 67)])
def test_it_is_the_papers_formula(
    file: Path, weights: dict[str, npt.NDArray[np.float32]], size: tuple[int, int]
) -> None:
    a, b = wave_pair(*size)
    got = Lpips(file)(torch.from_numpy(a).float(), torch.from_numpy(b).float())
    assert got == pytest.approx(reference(a, b, weights), rel=1e-4)
    assert got is not None
    assert got > 0.01


def test_equal_pictures_have_zero_and_tiny_ones_no_score(file: Path) -> None:
    lpips = Lpips(file)
    picture = torch.from_numpy(wave_pair(40, 40)[0]).float()
    assert lpips(picture, picture) == 0
    assert lpips(picture[:, :30], picture[:, :30]) is None


def test_of_a_region_pixels_of_layers_count_by_the_share_of_it_that_they_stand_for(
    file: Path, weights: dict[str, npt.NDArray[np.float32]]
) -> None:
    """Reference: the formula with the weights written out; everywhere gives the whole, nowhere gives none."""
    a, b = wave_pair(50, 67)
    pair = torch.from_numpy(a).float(), torch.from_numpy(b).float()
    region = np.zeros((50, 67), np.bool_)
    region[10:30, 20:31] = True
    expected = 0.0
    for i, (x, y) in enumerate(zip(features(a, weights), features(b, weights), strict=True)):
        x, y = (f / (np.linalg.norm(f, axis=2, keepdims=True) + 1e-10) for f in (x, y))
        distances = (x - y) ** 2 @ weights[f"NetLinLayer_{i}.Conv_0.kernel"].ravel()
        rows, columns = distances.shape
        share = np.empty((rows, columns))
        for r, c in np.ndindex(rows, columns):
            top, bottom = r * 50 // rows, -(-(r + 1) * 50 // rows)
            left, right = c * 67 // columns, -(-(c + 1) * 67 // columns)
            share[r, c] = region[top:bottom, left:right].mean()
        expected += (distances * share).sum() / share.sum()
    lpips = Lpips(file)
    whole, inside = lpips.with_region(*pair, torch.from_numpy(region))
    assert (whole, inside) == (lpips(*pair), pytest.approx(expected, rel=1e-4))
    assert lpips.with_region(*pair, torch.ones(50, 67, dtype=torch.bool))[1] == pytest.approx(whole)
    assert lpips.with_region(*pair, torch.zeros(50, 67, dtype=torch.bool))[1] is None
    assert lpips.with_region(pair[0][:, :30], pair[1][:, :30], torch.ones(30, 67, dtype=torch.bool)) == (None, None)


@pytest.mark.data
def test_it_agrees_with_the_authors_package(test_data: Callable[[str], Path]) -> None:
    a, b = (torch.from_numpy(picture).float() for picture in wave_pair(192, 208))
    # lpips 0.1.4, net="alex", normalize=True, with these weights of the convolutions
    assert Lpips(test_data("lpips/alexnet.npz"))(a, b) == pytest.approx(0.0999937, abs=2e-6)


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("AlexNet_0.Conv_1.bias", None, r"no array AlexNet_0\.Conv_1\.bias"),
        (
            "AlexNet_0.Conv_0.kernel",
            np.zeros((64, 3, 11, 11), np.float32),
            r"float32 \[64, 3, 11, 11\], expected floats",
        ),
        ("NetLinLayer_4.Conv_0.kernel", np.zeros((1, 1, 256, 1), np.int64), r"int64 \[1, 1, 256, 1\]"),
        ("AlexNet_0.Conv_2.bias", np.full(384, np.nan, np.float32), "NaN"),
    ],
)
def test_other_weights_are_refused(
    weights: dict[str, npt.NDArray[np.float32]],
    tmp_path: Path,
    name: str,
    value: npt.NDArray[np.float32] | None,
    problem: str,
) -> None:
    changed = {key: array for key, array in weights.items() if key != name}
    np.savez(tmp_path / "w.npz", **changed if value is None else changed | {name: value})  # type: ignore[arg-type]
    with pytest.raises(InputError, match=problem):
        Lpips(tmp_path / "w.npz")


def test_what_is_no_file_of_weights_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("weights")
    np.save(tmp_path / "single.npy", np.zeros(3))
    (tmp_path / "cut.npz").write_bytes(b"PK\x03\x04" + bytes(40))
    for name in ("absent.npz", "text.npz", "single.npy", "cut.npz", "."):
        with pytest.raises(InputError, match=r"docs/evaluation\.md"):
            Lpips(tmp_path / name)
