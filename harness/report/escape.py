"""Escape users' texts in pages, so that HTML or Markdown in them has no effect."""

import re
from collections.abc import Callable
from typing import Final

from markupsafe import Markup

_MARKDOWN: Final = re.compile(
    r"[&<`*\[\]|~\\]"
    r"|(?<![^\W_])_|_(?![^\W_])"  # an underscore inside a word is not emphasis (CommonMark 0.31, section 6.2)
    r"|^[#+=>-]"  # headings, lists, quotes and rules at the start of a line
)
"""Characters that CommonMark interprets in a text of one line."""
_HTML: Final = re.compile(rf"{_MARKDOWN.pattern}|[>\"']")
_NAMED: Final = {"&": "&amp;", "<": "&lt;", ">": "&gt;"}


def as_html(text: str) -> Markup:
    """Return a text for an HTML page, or for Markdown that becomes HTML: one line, special characters as entities."""
    return Markup(_escape(text, _HTML, lambda character: _NAMED.get(character, f"&#{ord(character)};")))


def as_markdown(text: str) -> str:
    """Return a text for a Markdown file: one line, special characters escaped by a backslash."""
    return _escape(text, _MARKDOWN, lambda character: f"\\{character}")


def _escape(text: str, special: re.Pattern[str], spell: Callable[[str], str]) -> str:
    line, head = _one_line(text), ""
    if number := re.match(r"(\d{1,9})([.)])(?=\s|$)", line, re.ASCII):  # an item of a list
        head, line = number[1] + spell(number[2]), line[number.end() :]
    return head + special.sub(lambda match: spell(match[0]), line)


def _one_line(text: str) -> str:
    """Return a text without line breaks and control characters, which would start another block."""
    return " ".join(re.sub(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]", " ", text).split())
