# SPDX-License-Identifier: MIT
"""What stands in the gnuplot scripts, by hand-made data; gnuplot draws each of them."""

import pathlib
import tempfile
import unittest

from maxlogdet_tools import gnuplot
from maxlogdet_tools.pictures import metrics, selection


class PictureTest(unittest.TestCase):
    def draw(self, picture):
        """Draws it into a .png, and checks the size that its header says."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "it's.png"
            gnuplot.draw(picture, file)
            header = file.read_bytes()[:24]
        self.assertEqual(header[1:4], b"PNG")
        self.assertEqual((int.from_bytes(header[16:20], "big"), int.from_bytes(header[20:24], "big")),
                         (picture.width, picture.height))


class Metrics(PictureTest):
    def test_curves_are_the_rows_of_their_noise(self):
        rows = [{"noise_px": noise, "size": size, "selector": selector, "rms_translation_m": "0." + size,
                 "ci95_of_rms_translation_m": "0.01", "rms_rotation_deg": "1", "ci95_of_rms_rotation_deg": "0.1"}
                for noise in ("1", "2") for size in ("15", "30") for selector in ("max_log_det", "all")]
        picture = metrics.picture(rows)
        self.assertIn("$all_1 << EOD\n15 0.15 0.01 1 0.1\n30 0.30 0.01 1 0.1\nEOD\n", picture.script)
        self.assertIn("set title 'noise 2 px'", picture.script)
        self.draw(picture)


class Selection(PictureTest):
    def test_the_map_reaches_as_far_as_the_selected(self):
        n = 200
        frame = {"frame": "it's", "width_px": 640, "height_px": 480, "right_m": [0.0] * n, "forward_m": [10.0] * n,
                 "u_px": [100.0] * n, "v_px": [50.0] * n, "selected": [3]}
        frame["forward_m"][5] = 500.0
        self.assertIn("set yrange [0:10.5]", selection.picture(frame).script, "one far point is left outside")
        self.assertIn("'it''s: 1 of 200 matches selected'", selection.picture(frame).script)
        frame["selected"] = [5]
        self.assertIn("set yrange [0:525]", selection.picture(frame).script)
        self.draw(selection.picture(frame))

    def test_an_empty_frame_has_a_picture(self):
        self.draw(selection.picture({"frame": "empty", "width_px": 640, "height_px": 480, "right_m": [], "forward_m": [],
                                     "u_px": [], "v_px": [], "selected": []}))


if __name__ == "__main__":
    unittest.main()
