"""The few SVG elements that charts are made of, and how much room words take."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

__all__ = ["FONT", "WIDTH", "box", "colour", "dot", "figure", "line", "path", "shortened", "text", "text_width"]

WIDTH = 400.0  # user units, about pixels; equal for all charts
FONT = 12.0  # height of letters, user units
_EM = 0.62  # width of the average letter of a wide sans-serif face
COLOURS = 8


def colour(index: int) -> str:
    """Return the colour of series number `index`; they repeat after eight."""
    return f"var(--s{index % COLOURS})"


def text_width(words: str) -> float:
    """Return about how wide `words` are drawn, user units."""
    return _EM * FONT * len(words)


def shortened(words: str, width: float) -> str:
    """Return `words`, cut with an ellipsis to about `width`."""
    fits = max(2, int(width / (_EM * FONT)))
    return words if len(words) <= fits else words[: fits - 1].rstrip() + "…"


def text(x: float, y: float, words: str, *, anchor: str = "start", kind: str = "") -> str:
    """Return words with a base line that starts, ends or is centred at (x, y); `kind` is a CSS class."""
    css = f' class="{kind}"' if kind else ""
    return f'<text x="{_n(x)}" y="{_n(y)}" text-anchor="{anchor}"{css}>{escape(words)}</text>'


def line(x0: float, y0: float, x1: float, y1: float, stroke: str = "var(--rule)", width: float = 1.0) -> str:
    """Return a straight line."""
    return (
        f'<line x1="{_n(x0)}" y1="{_n(y0)}" x2="{_n(x1)}" y2="{_n(y1)}" stroke="{stroke}" stroke-width="{_n(width)}"/>'
    )


def box(x: float, y: float, width: float, height: float, fill: str, tip: str = "") -> str:
    """Return a filled rectangle with a tooltip."""
    shape = f'<rect x="{_n(x)}" y="{_n(y)}" width="{_n(width)}" height="{_n(height)}" fill="{fill}"'
    return f"{shape}>{_tip(tip)}</rect>" if tip else f"{shape}/>"


def dot(x: float, y: float, radius: float, fill: str, stroke: str = "none", tip: str = "") -> str:
    """Return a disc with a tooltip."""
    shape = f'<circle cx="{_n(x)}" cy="{_n(y)}" r="{_n(radius)}" fill="{fill}" stroke="{stroke}" stroke-width="2"'
    return f"{shape}>{_tip(tip)}</circle>" if tip else f"{shape}/>"


def path(points: Sequence[tuple[float, float]], stroke: str) -> str:
    """Return an open line through the points."""
    steps = "L".join(f"{_n(x)} {_n(y)}" for x, y in points)
    return f'<path d="M{steps}" fill="none" stroke="{stroke}" stroke-width="1.8" stroke-linejoin="round"/>'


def figure(height: float, name: str, parts: Iterable[str]) -> str:
    """Return the chart; `name` is its description for screen readers."""
    return (
        f'<svg viewBox="0 0 {_n(WIDTH)} {_n(height)}" role="img" aria-label="{escape(name)}">'
        + "".join(parts)
        + "</svg>"
    )


def _tip(words: str) -> str:
    return f"<title>{escape(words)}</title>"


def _n(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
