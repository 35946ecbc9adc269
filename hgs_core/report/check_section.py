"""The section on the check of the capture: its table, its findings, and matches beside their epipolar lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from hgs_core.check.findings import CaptureCheck, ShownPair
from hgs_core.report.markup import note, section, table

__all__ = ["PairPictures", "check_section"]

_COLOURS = ("#e6194b", "#3cb44b", "#ffe119", "#4363d8", "#f58231", "#42d4f4", "#f032e6", "#bfef45")


@dataclass(frozen=True)
class PairPictures:
    """Two pictures of a check, data URIs."""

    pair: ShownPair
    first: str
    second: str


def check_section(check: CaptureCheck | None, pictures: Sequence[PairPictures]) -> str:
    """Return the section; a run of an earlier version has no check."""
    if check is None:
        return section("check", "The capture", [note("The capture was not checked: hgs check does it.")])
    about = (
        f"Before the training, matches in {len(check.frames)} moments were compared with the poses: px is the median "
        f"distance from the epipolar lines, in pixels of pictures {check.width} wide; ahead is by how many frames a "
        "camera is ahead of most others, told by what moves."
    )
    rows = [
        (
            one.name,
            str(one.partners),
            f"{one.matches:,}",
            "-" if one.error is None else f"{one.error:.2f}",
            "-" if one.ahead is None else f"{round(one.ahead, 1) + 0.0:+.1f}",
        )
        for one in check.cameras
    ]
    found = [
        f"<li><strong>{'In vain' if finding.stops else 'To look at'}:</strong> {escape(finding.sentence())}</li>"
        for finding in check.findings
    ]
    parts = [note(about), f"<ul>{''.join(found)}</ul>" if found else note("Nothing stood out.")]
    parts += [note(sentence) for sentence in check.given]
    parts += [_drawn(one) for one in pictures]
    parts.append(table("Cameras", ("camera", "partners", "matches", "px", "frames ahead"), rows))
    return section("check", "The capture", parts)


def _drawn(one: PairPictures) -> str:
    pair = one.pair
    first, second = pair.cameras
    words = (
        f"Frame {pair.frame}: points of {first}, and where {second} sees them. The lines are where the poses say that "
        f"they lie; they miss by {pair.error:.2f} px."
    )
    marks, lines = [], []
    for number, match in enumerate(pair.matches):
        colour = _COLOURS[number % len(_COLOURS)]
        marks.append(_dot(match.first, colour, pair.sizes[0][0]))
        ends = _ends(match.line, *pair.sizes[1])
        if ends:
            (x1, y1), (x2, y2) = ends
            lines.append(
                f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
                f'stroke-width="{pair.sizes[1][0] / 400:.2f}"/>'
            )
        lines.append(_dot(match.second, colour, pair.sizes[1][0]))
    return (
        '<div class="three">'
        + _figure(one.first, pair.sizes[0], f"Points, camera {first}", marks)
        + _figure(one.second, pair.sizes[1], f"Points and epipolar lines, camera {second}", lines)
        + f"</div>{note(words)}"
    )


def _figure(picture: str, size: tuple[int, int], words: str, marks: Sequence[str]) -> str:
    width, height = size
    return (
        f'<figure><svg viewBox="0 0 {width} {height}" role="img" aria-label="{escape(words)}">'
        f'<image href="{picture}" width="{width}" height="{height}"/>{"".join(marks)}</svg>'
        f"<figcaption>{escape(words)}</figcaption></figure>"
    )


def _dot(place: tuple[float, float], colour: str, width: int) -> str:
    return (
        f'<circle cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="{width / 100:.1f}" fill="none" stroke="{colour}" '
        f'stroke-width="{width / 250:.2f}"/>'
    )


def _ends(
    line: tuple[float, float, float], width: int, height: int
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return where a line enters and leaves the picture, None if it misses it."""
    a, b, c = line
    met = []
    if abs(b) > 1e-9:
        met += [(x, -(a * x + c) / b) for x in (0.0, float(width))]
    if abs(a) > 1e-9:
        met += [(-(b * y + c) / a, y) for y in (0.0, float(height))]
    inside = sorted({(x, y) for x, y in met if -0.01 <= x <= width + 0.01 and -0.01 <= y <= height + 0.01})
    return (inside[0], inside[-1]) if len(inside) > 1 else None
