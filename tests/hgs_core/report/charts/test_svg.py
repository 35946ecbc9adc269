from __future__ import annotations

from xml.etree import ElementTree

import pytest

from hgs_core.report.charts.svg import FONT, box, colour, dot, figure, line, path, shortened, text, text_width

NASTY = "<b> & \"quoted\" 'words'"


def test_colours_repeat_after_eight() -> None:
    assert len({colour(number) for number in range(8)}) == 8
    assert colour(8) == colour(0) == "var(--s0)"


def test_words_are_cut_to_the_width_they_may_have() -> None:
    assert shortened("a short name", 200) == "a short name"
    cut = shortened("a name that is a good deal longer", 100)
    assert cut.endswith("…")
    assert text_width(cut) <= 100
    assert text_width("a name that is a good deal longer") > 100


def test_hardly_any_width_still_shows_a_letter() -> None:
    assert shortened("name", 0) == "n…"


def test_no_blank_stands_before_the_ellipsis() -> None:
    assert shortened("ab cdefgh", 4 * 0.62 * FONT) == "ab…"


@pytest.mark.parametrize("made", [text(0, 0, NASTY), box(0, 0, 1, 1, "red", NASTY), dot(0, 0, 1, "red", tip=NASTY)])
def test_words_are_never_markup(made: str) -> None:
    assert "".join(ElementTree.fromstring(made).itertext()) == NASTY


def test_a_figure_is_named_for_those_who_cannot_see_it() -> None:
    svg = ElementTree.fromstring(figure(123.45, NASTY, [line(0, 1, 2, 3)]))
    assert (svg.attrib["role"], svg.attrib["aria-label"]) == ("img", NASTY)
    assert svg.attrib["viewBox"] == "0 0 400 123.5"
    assert [child.tag for child in svg] == ["line"]


def test_a_path_goes_through_its_points_in_order() -> None:
    assert 'd="M1 2L3.5 4L5 6"' in path([(1, 2), (3.5, 4), (5, 6)], "red")


def test_shapes_without_a_tooltip_have_none() -> None:
    assert "title" not in box(0, 0, 1, 1, "red") + dot(0, 0, 1, "red")
