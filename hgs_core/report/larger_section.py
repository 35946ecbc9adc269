"""The section with pictures of larger screens and nearer eyes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from hgs_core.report.larger_pictures import Crop, LargerPictures
from hgs_core.report.markup import image, note, section, table
from hgs_core.report.sources import FinishedRun, finite_number

__all__ = ["larger_section"]

_PLACES = ("the camera's place", "a third of the way to what moves", "two thirds of the way")


def larger_section(run: FinishedRun, cameras: Sequence[LargerPictures]) -> str:
    """Return the section; the scores are those of `hgs eval --magnify`, if it has measured any."""
    measured = run.scores.get("magnified")
    parts = [_table(measured)] if isinstance(measured, dict) else [note("Mean scores: hgs eval RUN --magnify 2,4.")]
    if cameras:
        parts.append(
            note("The part of the picture where a picture twice as large is least like it, and a walk to what moves.")
        )
    for number, pictures in enumerate(cameras):
        opened = " open" if number == 0 else ""
        summary = f"Camera {pictures.camera}, frame {pictures.frame}, {pictures.seconds:.2f} s"
        parts.append(
            f"<details{opened}><summary>{escape(summary)}</summary>{_crops(pictures)}{_walk(pictures)}</details>"
        )
    return section("larger", "Larger screens", parts)


def _table(scores: Mapping[str, Any]) -> str:
    factors = sorted(
        int(name[len("agreement_") : -1]) for name in scores if name.startswith("agreement_") and name.endswith("x")
    )
    rows = [("training size", _decibels(scores, "psnr"), "")]
    for factor in factors:
        rows.append((f"{factor}x", _decibels(scores, f"psnr_{factor}x"), _decibels(scores, f"agreement_{factor}x")))
    for step, place in enumerate(_PLACES[1:], start=1):
        rows.append((place, "", _decibels(scores, f"agreement_walked_{step}_of_3")))
    return table("Means over scored cameras, dB", ("drawn at", "PSNR", "agreement with the training size"), rows)


def _decibels(scores: Mapping[str, Any], name: str) -> str:
    value = finite_number(scores.get(name))
    return "" if value is None else f"{value:.2f}"


def _crops(pictures: LargerPictures) -> str:
    figures = "".join(
        f"<figure>{image(crop.picture, pictures.crop_size, f'{_size(crop)}, camera {pictures.camera}', 'sharp')}"
        f"<figcaption>{escape(_caption(crop))}</figcaption></figure>"
        for crop in pictures.crops
    )
    return f'<div class="three">{figures}</div>'


def _caption(crop: Crop) -> str:
    if crop.agreement is None:
        return _size(crop)
    return f"{_size(crop)}, averaged {crop.agreement:.1f} dB from the training size"


def _size(crop: Crop) -> str:
    return "Training size" if crop.factor == 1 else f"{crop.factor}x"


def _walk(pictures: LargerPictures) -> str:
    figures = "".join(
        f"<figure>{image(picture, pictures.size, f'From {place}, camera {pictures.camera}')}"
        f"<figcaption>From {escape(place)}</figcaption></figure>"
        for place, picture in zip(_PLACES, pictures.walk, strict=True)
    )
    return f'<div class="three">{figures}</div>'
