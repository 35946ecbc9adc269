"""Charts as elements with numbers and words."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

__all__ = ["elements", "number", "place", "tip", "words"]


def elements(chart: str, tag: str) -> list[Element]:
    """Return the elements of a kind, in the order in which they are drawn."""
    return list(ElementTree.fromstring(chart).iter(tag))


def number(element: Element, name: str) -> float:
    """Return an attribute that is a number."""
    return float(element.attrib[name])


def tip(element: Element) -> str:
    """Return the tooltip of an element, "" without one."""
    return element.findtext("title", "")


def words(chart: str) -> list[str]:
    """Return all words that are drawn."""
    return [element.text or "" for element in elements(chart, "text")]


def place(chart: str, word: str) -> Element:
    """Return where these words are drawn, which is once."""
    (found,) = (element for element in elements(chart, "text") if element.text == word)
    return found
