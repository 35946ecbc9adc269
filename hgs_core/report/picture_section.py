"""The section with the pictures: wipes, error maps, and the part of dynamic splats."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from hgs_core.report.error_colours import ERROR_RANGE, colour_table
from hgs_core.report.markup import image, note, section
from hgs_core.report.pictures import MOVING_COLOUR, CameraPictures, Moment
from hgs_core.report.sources import FinishedRun

__all__ = ["picture_section"]

_GRADIENT_STOPS = 17  # stops of the scale's gradient


def picture_section(run: FinishedRun, cameras: Sequence[CameraPictures], reason: str) -> str:
    """Return the section; `reason` says why there are no pictures."""
    if not cameras:
        return section("pictures", "Pictures", [note(f"No pictures: {reason}.")])
    parts = [note(_about(run, cameras)), _scale()]
    for number, camera in enumerate(cameras):
        trained = camera.camera not in run.spec.config.capture.hold_out
        summary = f"Camera {camera.camera}" + (" (training saw it)" if trained else " (held out)")
        moments = "".join(_moment(camera.camera, moment) for moment in camera.moments)
        opened = " open" if number == 0 else ""
        parts.append(f"<details{opened}><summary>{escape(summary)}</summary>{moments}</details>")
    return section("pictures", "Pictures", parts)


def _about(run: FinishedRun, cameras: Sequence[CameraPictures]) -> str:
    scored = run.scores.get("cameras", [])
    words = (
        "The decoded scene beside the capture's frames: moments from equal parts of the capture, and the worst frame."
    )
    if not run.spec.config.capture.hold_out and not scored:
        words = f"No camera was held out: these are training cameras, whose pictures training has seen. {words}"
    if len(scored) > len(cameras):
        words += f" {len(cameras)} of {len(scored)} scored cameras are shown."
    if run.scores.get("truth") == "given":
        words += " The scores are against pictures that were given to hgs eval, not against these frames."
    return words


def _scale() -> str:
    """The key of the error maps and of the colour of dynamic splats."""
    table = colour_table()
    stops = ", ".join(
        "#" + "".join(f"{channel:02x}" for channel in table[round(255 * k / (_GRADIENT_STOPS - 1))])
        for k in range(_GRADIENT_STOPS)
    )
    ticks = [f"{ERROR_RANGE * k / 4:.2f}" for k in range(5)]
    ticks[-1] = "≥ " + ticks[-1]
    words = "Mean absolute difference of R, G and B, sRGB in [0, 1]"
    moving = ", ".join(map(str, MOVING_COLOUR))
    return (
        f'<div class="keys"><div class="scale"><p>Error: {words[0].lower()}{escape(words[1:])}</p>'
        f'<div class="ramp" style="background: linear-gradient(to right, {stops})"></div>'
        f"<div class='ticks'>{''.join(f'<span>{tick}</span>' for tick in ticks)}</div></div>"
        f'<p class="key"><span class="swatch" style="background: rgb({moving})"></span>'
        "drawn by dynamic splats, the rest by static ones (grey)</p></div>"
    )


def _moment(camera: str, moment: Moment) -> str:
    where = f"camera {camera}, frame {moment.frame}"
    title = f"Frame {moment.frame}, {moment.seconds:.2f} s: {moment.psnr:.2f} dB"
    worst = ' <span class="badge">worst frame</span>' if moment.worst else ""
    return (
        f'<div class="moment"><h3>{escape(title)}{worst}</h3><div class="three">'
        f"<figure>{_wipe(moment, where)}"
        "<figcaption>Left of the line what is drawn, right of it the truth</figcaption></figure>"
        f"<figure>{image(moment.error, moment.size, f'Error map, {where}')}<figcaption>Error</figcaption></figure>"
        f"<figure>{image(moment.moving, moment.size, f'Share of dynamic splats, {where}')}"
        f"<figcaption>Dynamic splats draw {moment.dynamic_share:.1%} of the pixels</figcaption></figure>"
        "</div></div>"
    )


def _wipe(moment: Moment, where: str) -> str:
    """Two pictures one over the other; the upper one is drawn left of the line. The whole picture is the slider."""
    return (
        f'<div class="wipe">{image(moment.truth, moment.size, f"Truth, {where}")}'
        f"{image(moment.drawn, moment.size, f'Drawn, {where}', 'over')}"
        '<span class="tag left" aria-hidden="true">drawn</span><span class="tag right" aria-hidden="true">truth</span>'
        '<span class="line" aria-hidden="true"></span>'
        f'<input type="range" min="0" max="100" value="50" step="0.5" aria-label="{escape(f"Share drawn, {where}")}">'
        "</div>"
    )
