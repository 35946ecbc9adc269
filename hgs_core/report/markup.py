"""The pieces of HTML that sections are made of. Words are escaped here; arguments named `html` are markup already."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

__all__ = ["chart", "image", "note", "pairs", "section", "table"]


def section(anchor: str, title: str, html: Iterable[str]) -> str:
    """Return a section with a heading that can be linked to."""
    return f'<section id="{anchor}" aria-labelledby="{anchor}-title"><h2 id="{anchor}-title">{escape(title)}</h2>' + (
        "\n".join(html) + "</section>"
    )


def note(words: str) -> str:
    """Return a paragraph of small print."""
    return f'<p class="note">{escape(words)}</p>'


def chart(title: str, html: str, words: str = "") -> str:
    """Return a chart under its title, with an explanation below."""
    below = note(words) if words else ""
    return f'<figure class="chart"><figcaption>{escape(title)}</figcaption>{html}{below}</figure>'


def image(uri: str, size: tuple[int, int], words: str, kind: str = "") -> str:
    """Return a picture of `size` (width, height, in pixels) in a style of page.css, described by words."""
    css = f' class="{kind}"' if kind else ""
    width, height = size
    return f'<img{css} src="{uri}" width="{width}" height="{height}" alt="{escape(words)}" decoding="async">'


def pairs(facts: Mapping[str, str]) -> str:
    """Return names with their values beside them, or below them where the page is narrow."""
    rows = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in facts.items())
    return f'<dl class="pairs">{rows}</dl>'


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table with the rows' names in its first column; it scrolls sideways on a narrow page."""
    cells = "".join(f'<th scope="col">{escape(words)}</th>' for words in head)
    lines = "".join(
        f'<tr><th scope="row">{escape(row[0])}</th>'
        + "".join(f"<td>{escape(words)}</td>" for words in row[1:])
        + "</tr>"
        for row in rows
    )
    label = escape(caption)
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{label}"><table><caption>{label}</caption>'
        f"<thead><tr>{cells}</tr></thead><tbody>{lines}</tbody></table></div>"
    )
