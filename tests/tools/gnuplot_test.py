# SPDX-License-Identifier: MIT
"""How drawing fails, and what it leaves behind then."""

import math
import os
import pathlib
import tempfile
import unittest
from unittest import mock

from maxlogdet_tools import gnuplot

DOT = gnuplot.Picture(200, 100, "plot '-'\n0 0\ne\n")


class Draw(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def message(self, picture, file):
        with self.assertRaises(SystemExit) as ended:
            gnuplot.draw(picture, file)
        return ended.exception.code

    def test_says_what_is_missing(self):
        file = self.folder / "dot.svg"
        with mock.patch.dict(os.environ, PATH="nowhere"):
            self.assertEqual(self.message(DOT, file), f"{file}: cannot be drawn; expected gnuplot to be installed "
                                                      "(Debian: apt-get install gnuplot-nox)")

    def test_says_why_gnuplot_failed_and_leaves_an_older_picture(self):
        file = self.folder / "dot.svg"
        file.write_text("an old picture")
        self.assertIn(f"{file}: gnuplot could not draw it: ", self.message(gnuplot.Picture(9, 9, "plot nothing\n"), file))
        self.assertEqual(file.read_text(), "an old picture")

    def test_says_which_endings_there_are(self):
        self.assertIn("dot.bmp: expected a picture that ends in .svg or .png", self.message(DOT, "dot.bmp"))

    def test_says_that_a_picture_cannot_be_written(self):
        self.assertIn("cannot be written (No such file or directory)", self.message(DOT, self.folder / "no/dot.svg"))
        self.assertIn("cannot be written (File name too long)", self.message(DOT, self.folder / (300 * "a" + ".svg")))

    def test_leaves_no_half_of_a_picture(self):
        file = self.folder / "dot.svg"
        file.write_text("an old picture")
        with mock.patch.object(pathlib.Path, "write_bytes", side_effect=OSError(28, "No space left on device")):
            self.assertIn("cannot be written (No space left on device)", self.message(DOT, file))
        self.assertEqual(file.read_text(), "an old picture")
        self.assertEqual(list(self.folder.iterdir()), [file])

    def test_a_device_stays_a_device(self):
        link = self.folder / "full.svg"
        link.symlink_to("/dev/full")
        self.assertIn("cannot be written (No space left on device)", self.message(DOT, link))
        self.assertTrue(pathlib.Path("/dev/full").is_char_device())

    def test_a_link_stays_a_link(self):
        link, target = self.folder / "link.svg", self.folder / "target.svg"
        link.symlink_to(target)
        gnuplot.draw(DOT, link)
        self.assertTrue(link.is_symlink())
        self.assertIn("</svg>", target.read_text())


class Text(unittest.TestCase):
    def test_numbers_keep_all_digits(self):
        self.assertEqual([gnuplot.number(x) for x in (1, 2.0, -0.5, 1 / 3, None, math.nan)],
                         ["1", "2", "-0.5", "0.3333333333333333", "NaN", "NaN"])

    def test_quotes_are_doubled(self):
        self.assertEqual(gnuplot.quoted("it's"), "'it''s'")

    def test_blocks_without_rows_hold_no_point(self):
        self.assertEqual(gnuplot.data_block("d", []), "$d << EOD\nNaN NaN NaN NaN\nEOD\n")


if __name__ == "__main__":
    unittest.main()
