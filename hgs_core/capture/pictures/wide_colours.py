"""Pictures of wide colours or high dynamic range, as an ordinary screen shows them.

Phones film in HLG, cameras in PQ (ITU-R BT.2100), with the primaries of BT.2020. Splats are trained in the colours of
BT.709. Light is brought there with diffuse white at 203 cd/m2 (BT.2408), highlights up to 1000 cd/m2 are compressed by
the curve of BT.2390 on the largest of the three channels, which keeps hues, and what BT.709 has no colours for is cut
off. The curve is the same for every frame and camera.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["WideColours", "wide_colours_of"]

_WHITE = 203.0  # cd/m2 of diffuse white, which becomes 1
_PEAK = 1000.0  # cd/m2 that are told apart
_DISPLAY_GAMMA = 2.4  # BT.1886, the display of BT.709 pictures
_TABLE = 4096  # entries of the curve's table, evenly over the root of the light

# FFmpeg's numbers (ITU-T H.273)
_PQ, _HLG, _BT2020_10, _BT2020_12 = 16, 18, 14, 15
_BT2020, _P3 = 9, 12

_TO_BT709 = {  # matrices on linear light
    _BT2020: [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]],
    _P3: [[1.2249, -0.2249, 0.0], [-0.0421, 1.0421, 0.0], [-0.0196, -0.0786, 1.0983]],
}

Floats = npt.NDArray[np.float32]


@dataclass(frozen=True)
class WideColours:
    """How a video's numbers stand for light."""

    transfer: int
    primaries: int

    @property
    def name(self) -> str:
        """Say it for people."""
        curve = {_PQ: "HDR (PQ)", _HLG: "HDR (HLG)"}.get(self.transfer)
        return curve or {_BT2020: "BT.2020 colours", _P3: "P3 colours"}[self.primaries]

    def shown(self, picture: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint8]:
        """Return a picture [H, W, 3] of 16 bits, full range, in BT.709's colours and 8 bits."""
        light = _light_table(self.transfer)[picture]  # light relative to white, or HLG's scene light
        if self.transfer == _HLG:
            luminance = light @ np.array([0.2627, 0.678, 0.0593], np.float32)
            light *= (np.float32(_PEAK / _WHITE) * np.maximum(luminance, 1e-6) ** np.float32(0.2))[..., None]
        if self.transfer in (_PQ, _HLG):
            brightest = np.sqrt(np.clip(light.max(axis=2) * np.float32(_WHITE / _PEAK), 0, 1))
            light *= _curve()[(brightest * (_TABLE - 1) + 0.5).astype(np.int32)][..., None]
        if self.primaries in _TO_BT709:
            light = light @ np.array(_TO_BT709[self.primaries], np.float32).T
        signal = np.clip(light, 0, 1) ** np.float32(1 / _DISPLAY_GAMMA)
        return np.asarray(signal * 255 + 0.5, np.uint8)


def wide_colours_of(frame: Any) -> WideColours | None:
    """Return the colours that a decoded frame's tags state; None for ordinary ones."""
    transfer, primaries = int(frame.color_trc or 0), int(frame.color_primaries or 0)
    if transfer in (_PQ, _HLG) and primaries not in _TO_BT709:
        primaries = _BT2020  # BT.2100's, as the default without a tag
    if transfer in (_PQ, _HLG) or primaries in _TO_BT709:
        return WideColours(transfer, primaries)
    return None


@functools.cache
def _light_table(transfer: int) -> Floats:
    """Return light by signal, 65536 values: of diffuse white, but of the scene's peak for HLG."""
    signal = np.arange(65536) / 65535
    if transfer == _PQ:
        return np.asarray(_from_pq(signal) / _WHITE, np.float32)
    if transfer == _HLG:
        a, b, c = 0.17883277, 0.28466892, 0.55991073
        low, high = signal**2 / 3, (np.exp((np.maximum(signal, 0.5) - c) / a) + b) / 12
        return np.where(signal <= 0.5, low, high).astype(np.float32)
    return np.asarray(signal**_DISPLAY_GAMMA, np.float32)


@functools.cache
def _curve() -> Floats:
    """Return the factors of BT.2390's curve on light, evenly over the root of light in shares of the peak."""
    light = np.linspace(0, 1, _TABLE) ** 2 * _PEAK
    whole = _to_pq(np.array(_PEAK))
    most = float(_to_pq(np.array(_WHITE)) / whole)
    knee = 1.5 * most - 0.5
    given = _to_pq(light) / whole
    t = np.clip((given - knee) / (1 - knee), 0, 1)
    bent = (2 * t**3 - 3 * t**2 + 1) * knee + (t**3 - 2 * t**2 + t) * (1 - knee) + (-2 * t**3 + 3 * t**2) * most
    shown = _from_pq(np.where(given < knee, given, bent) * whole)
    return np.asarray(np.where(light > 1e-3, shown / np.maximum(light, 1e-3), 1.0), np.float32)


def _from_pq(signal: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return cd/m2 of a PQ signal (SMPTE ST 2084)."""
    power = signal ** (1 / 78.84375)
    return np.asarray(
        10000 * (np.maximum(power - 0.8359375, 0) / (18.8515625 - 18.6875 * power)) ** (1 / 0.1593017578125)
    )


def _to_pq(light: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    power = (light / 10000) ** 0.1593017578125
    return np.asarray(((0.8359375 + 18.8515625 * power) / (1 + 18.6875 * power)) ** 78.84375)
