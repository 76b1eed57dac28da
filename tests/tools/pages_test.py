# SPDX-License-Identifier: MIT
"""Tables in Markdown pages."""

import contextlib
import io
import pathlib
import tempfile
import unittest

from maxlogdet_tools import pages


class Pages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.page = pathlib.Path(folder.name) / "page.md"

    def test_tables_have_a_line_a_row(self):
        self.assertEqual(pages.table(["a", "b"], [["1", "2"], ["3", "4"]]),
                         ["a | b", "---|---", "1 | 2", "3 | 4"])

    def test_paragraphs_are_wrapped_between_words(self):
        lines = pages.paragraph("word " * 30, "`a-b`" * 40)
        self.assertEqual(len(lines), 3)
        self.assertLessEqual(max(len(line) for line in lines[:2]), 120)
        self.assertEqual(lines[2], "`a-b`" * 40, "longer than a line, but one word")

    def test_replaces_what_stands_between(self):
        self.page.write_text("head [old] tail\n")
        pages.replace_between(self.page, "[", "]", "new")
        self.assertEqual(self.page.read_text(), "head [new] tail\n")

    def test_rewrites_the_lines_of_a_name(self):
        self.page.write_text("x\n<!-- begin t -->\nold\n<!-- end t -->\ny\n")
        with contextlib.redirect_stdout(io.StringIO()) as said:
            pages.rewrite(self.page, "t", ["one", "two"])
        self.assertEqual(self.page.read_text(), "x\n<!-- begin t -->\none\ntwo\n<!-- end t -->\ny\n")
        self.assertEqual(said.getvalue(), f"rewrote t in {self.page}\n")

    def test_refuses_a_page_without_the_place_or_with_two(self):
        for text in ("", "[", "]", "][", "[][]"):
            self.page.write_text(text)
            with self.assertRaisesRegex(SystemExit, "page.md: expected '\\[' once, and after it '\\]' once"):
                pages.replace_between(self.page, "[", "]", "new")
            self.assertEqual(self.page.read_text(), text)


if __name__ == "__main__":
    unittest.main()
