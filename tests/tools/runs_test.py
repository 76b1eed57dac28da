# SPDX-License-Identifier: MIT
"""The lines of a page that say on which state of the library its figures were measured."""

import contextlib
import io
import pathlib
import re
import tempfile
import unittest
from unittest import mock

from maxlogdet_tools import runs


def quietly(function, *arguments):
    with contextlib.redirect_stdout(io.StringIO()) as said:
        function(*arguments)
    return said.getvalue()


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.page = self.root / "README.md"
        self.page.write_text("x\n<!-- begin run -->\n<!-- end run -->\ny\n")

    def test_a_command_has_one_line_a_page_which_its_next_run_replaces(self):
        with mock.patch.object(runs, "library_state", lambda: "11111111"):
            for room in ("how_good", "how_fast", "how_fast --threads"):
                quietly(runs.stamp, self.page, room)
        with mock.patch.object(runs, "library_state", lambda: "22222222"):
            quietly(runs.stamp, self.page, "how_fast")
        states = [runs.LINE.match(line).groups() for line in runs.lines_of(self.page)]
        self.assertEqual(states, [("bench/run how_fast --threads", "11111111"), ("bench/run how_fast", "22222222"),
                                  ("bench/run how_good", "11111111")])
        self.assertTrue(self.page.read_text().endswith("<!-- end run -->\ny\n"))

    def test_pages_of_another_state_are_marked(self):
        (self.root / "docs").mkdir()
        with mock.patch.object(runs, "ROOT", self.root), mock.patch.object(runs.sys, "argv", ["runs"]):
            with mock.patch.object(runs, "library_state", lambda: "11111111"):
                quietly(runs.stamp, self.page, "how_good")
                self.assertNotIn("another state", quietly(runs.main))
            with mock.patch.object(runs, "library_state", lambda: "22222222"):
                self.assertRegex(quietly(runs.main), "^README.md: Written by `bench/run how_good`.*<- another state")

    def test_a_state_is_a_commit_and_what_has_changed_since(self):
        self.assertTrue(re.fullmatch(r"unknown|[0-9a-f]{8,}(\+[0-9a-f]{6})?", runs.library_state()), runs.library_state())
        with mock.patch.object(runs, "output_of", lambda *command: "abcdef12" if command[1] == "log" else "- a\n+ b"):
            self.assertRegex(runs.library_state(), r"^abcdef12\+[0-9a-f]{6}$")
        with mock.patch.object(runs, "output_of", lambda *command: ""):
            self.assertEqual(runs.library_state(), "unknown")


if __name__ == "__main__":
    unittest.main()
