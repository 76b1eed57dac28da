# SPDX-License-Identifier: MIT
"""Markdown pages whose tables are written by programs."""

import pathlib
import sys
import textwrap

from maxlogdet_tools.project import shown

WIDTH = 120


def table(header, rows):
    """The lines of a Markdown table; cells are texts, those of the first column not empty."""
    return [" | ".join(header), "|".join(["---"] * len(header)), *(" | ".join(row) for row in rows)]


def paragraph(*sentences):
    """The lines of a paragraph."""
    return textwrap.wrap(" ".join(sentences), WIDTH, break_long_words=False, break_on_hyphens=False)


def replace_between(page, begin, end, text):
    """Replaces the text between the only `begin` and the only `end` of a page."""
    page = pathlib.Path(page)
    old = page.read_text()
    if old.count(begin) != 1 or old.count(end) != 1 or old.index(begin) > old.index(end):
        sys.exit(f"{page}: expected '{begin}' once, and after it '{end}' once")
    head, rest = old.split(begin)
    page.write_text(head + begin + text + end + rest.split(end)[1])


def rewrite(page, name, lines):
    """Rewrites the lines between '<!-- begin NAME -->' and '<!-- end NAME -->' of a page, and prints its name."""
    replace_between(page, f"<!-- begin {name} -->", f"<!-- end {name} -->", "\n" + "\n".join(lines) + "\n")
    print(f"rewrote {name} in {shown(page)}")
