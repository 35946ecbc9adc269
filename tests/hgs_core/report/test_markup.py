from __future__ import annotations

from xml.etree import ElementTree

import pytest

from hgs_core.report.markup import chart, note, pairs, section, table

NASTY = "<b> & \"quoted\" 'words'"


@pytest.mark.parametrize(
    "made",
    [
        note(NASTY),
        section("a", NASTY, []),
        chart(NASTY, "", NASTY),
        pairs({NASTY: NASTY}),
        table(NASTY, [NASTY], [[NASTY, NASTY]]),
    ],
)
def test_words_are_never_markup(made: str) -> None:
    parsed = ElementTree.fromstring(made)
    assert "".join(parsed.itertext()).replace(NASTY, "") == ""
    assert parsed.find(".//b") is None


def test_a_section_can_be_linked_to_and_is_named_by_its_heading() -> None:
    parsed = ElementTree.fromstring(section("size", "Size", ["<p>one</p>", "<p>two</p>"]))
    heading = parsed.find("h2")
    assert heading is not None
    assert (parsed.attrib["id"], parsed.attrib["aria-labelledby"]) == ("size", heading.attrib["id"])
    assert [child.text for child in parsed] == ["Size", "one", "two"]


def test_the_first_column_of_a_table_names_its_rows() -> None:
    parsed = ElementTree.fromstring(table("All", ("run", "MB"), [("ours", "1"), ("theirs", "2")]))
    assert [cell.text for cell in parsed.iter("th")] == ["run", "MB", "ours", "theirs"]
    assert [cell.attrib["scope"] for cell in parsed.iter("th")] == ["col", "col", "row", "row"]
    assert [cell.text for cell in parsed.iter("td")] == ["1", "2"]


def test_a_chart_without_explanation_has_none() -> None:
    assert "note" not in chart("title", "<svg/>")
    assert "note" in chart("title", "<svg/>", "words")
