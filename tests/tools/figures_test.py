# SPDX-License-Identifier: MIT
"""What would make a published figure wrong: how scripts read results, write pictures and pages, and say of which
state of the library they are; and which runs are too noisy to publish."""

import contextlib
import io
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

from maxlogdet_tools import gnuplot, pages
from maxlogdet_tools.pictures import metrics

RESULTS = pathlib.Path(__file__).resolve().parents[2] / "bench/how_fast/results.py"


def quietly(function, *arguments):
    with contextlib.redirect_stdout(io.StringIO()) as said:
        function(*arguments)
    return said.getvalue()


class Pictures(unittest.TestCase):
    def test_curves_of_pictures_are_the_rows_of_their_noise_with_all_digits(self):
        rows = [{"noise_px": noise, "size": size, "selector": selector, "rms_translation_m": "0." + size,
                 "ci95_of_rms_translation_m": "0.01", "rms_rotation_deg": "1", "ci95_of_rms_rotation_deg": "0.1"}
                for noise in ("1", "2") for size in ("15", "30") for selector in ("max_log_det", "all")]
        picture = metrics(rows)
        self.assertIn("$all_1 << EOD\n15 0.15 0.01 1 0.1\n30 0.30 0.01 1 0.1\nEOD\n", picture.script)
        self.assertEqual([gnuplot.number(x) for x in (2.0, -0.5, 1 / 3, None)], ["2", "-0.5", "0.3333333333333333", "NaN"])


class Pages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.page = self.folder / "README.md"

    def test_the_lines_of_a_name_are_replaced_and_nothing_else(self):
        self.page.write_text("x\n<!-- begin t -->\nold\n<!-- end t -->\ny\n")
        quietly(pages.rewrite, self.page, "t", ["one", "two"])
        self.assertEqual(self.page.read_text(), "x\n<!-- begin t -->\none\ntwo\n<!-- end t -->\ny\n")
        for text in ("", "[", "]", "][", "[][]"):
            self.page.write_text(text)
            with self.assertRaisesRegex(SystemExit, "README.md: expected '\\[' once, and after it '\\]' once"):
                pages.replace_between(self.page, "[", "]", "new")
            self.assertEqual(self.page.read_text(), text)

    def test_a_command_has_one_line_a_page_which_its_next_run_replaces(self):
        self.page.write_text("x\n<!-- begin run -->\n<!-- end run -->\ny\n")
        for state, rooms in (("11111111", ("how_good", "how_fast", "how_fast --threads")), ("22222222", ("how_fast",))):
            with mock.patch.object(pages, "library_state", lambda state=state: state):
                for room in rooms:
                    quietly(pages.stamp, self.page, room)
        states = [pages.LINE.match(line).groups() for line in pages.lines_of(self.page)]
        self.assertEqual(states, [("bench/run how_fast --threads", "11111111"), ("bench/run how_fast", "22222222"),
                                  ("bench/run how_good", "11111111")])
        (self.folder / "docs").mkdir()
        with mock.patch.object(pages, "ROOT", self.folder), mock.patch.object(pages.sys, "argv", ["runs"]), \
                mock.patch.object(pages, "library_state", lambda: "22222222"):
            marked = [" <- another state" in line for line in quietly(pages.main).splitlines()]
        self.assertEqual(marked, [True, False, True])

    def test_a_state_is_a_commit_and_what_has_changed_since(self):
        self.assertTrue(re.fullmatch(r"unknown|[0-9a-f]{8,}(\+[0-9a-f]{6})?", pages.library_state()), pages.library_state())
        with mock.patch.object(pages, "output_of", lambda *command: "abcdef12" if command[1] == "log" else "- a\n+ b"):
            self.assertRegex(pages.library_state(), r"^abcdef12\+[0-9a-f]{6}$")


STEADY = [100, 100, 100, 200, 100, 100, 200, 100]
LATER_SLOWER = [100] * 4 + [106] * 4


class Noise(unittest.TestCase):
    def judged(self, baseline, *others):
        """The message of results.py for blocks that took these times, us; Google Benchmark does not keep to an order."""
        cases = {"baseline/eigen/iterations:1": baseline, **{f"grid/greedy/n:{i}": times for i, times in enumerate(others)}}
        blocks = [{"run_name": name, "run_type": "iteration", "repetition_index": i, "real_time": time, "calls": i}
                  for name, times in cases.items() for i, time in reversed(list(enumerate(times)))]  # fmt: skip
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump({"context": {"maxlogdet_isa": "avx2"}, "benchmarks": blocks}, file)
            file.flush()
            return subprocess.run([sys.executable, RESULTS, file.name], capture_output=True, text=True).stderr

    def test_a_run_may_be_published_if_neither_its_baseline_nor_half_of_its_cases_changed(self):
        refused = "too noisy to publish: the two halves of the run differ by 6 %, expected at most 5 %\n"
        for baseline in (STEADY, [100] * 4 + [104] * 4):
            self.assertEqual(self.judged(baseline, STEADY, LATER_SLOWER), "")
        for baseline in (LATER_SLOWER, LATER_SLOWER[::-1]):
            self.assertEqual(self.judged(baseline, STEADY, STEADY), refused)
        self.assertEqual(self.judged(STEADY, LATER_SLOWER, LATER_SLOWER[::-1]), refused)
        self.assertIn("expected the case baseline/eigen_lazy_scan", self.judged([], STEADY))


if __name__ == "__main__":
    unittest.main()
