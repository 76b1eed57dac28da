# SPDX-License-Identifier: MIT
"""What stands in the gnuplot scripts, by hand-made data; gnuplot draws each of them."""

import pathlib
import tempfile
import unittest

from maxlogdet_tools import gnuplot
from maxlogdet_tools.pictures import epsilon, metrics, selection, tracking


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


def tracking_row(sequence, run, selector, ate, rpe, roe, budget=0.0):
    return {"sequence": sequence, "run": run, "selector": selector, "budget": budget, "ate_m": ate, "rpe_m_per_s": rpe,
            "roe_deg_per_s": roe}


class Tracking(PictureTest):
    def test_bars_are_means_over_runs(self):
        rows = [tracking_row(sequence, run, selector, ate + run - 0.5, 1.0, None)
                for sequence, means in {"A": (2, 0.5, 3, 2), "B": (1, 4, 3, 2)}.items()
                for run in (0, 1) for selector, ate in zip(("md", "quality", "all", "inl"), means)]
        picture = tracking.euroc({}, rows)["euroc"]
        self.assertIn("$errors3 << EOD\nA 2 0.5 3 2\nB 1 4 3 2\nEOD\n", picture.script)
        self.assertNotIn("$errors2", picture.script, "an error that no run has")
        self.draw(picture)

    def test_boxes_are_quartiles(self):
        rows = []
        for run in range(5):
            e = run + 1.0
            rows += [tracking_row("A", run, "md", e, 10 * e, 100 * e, 40.0), tracking_row("A", run, "md", 2, 2, 2, 60.0),
                     tracking_row("A", run, "inl", 3, 3, 3)]
        picture = tracking.budget({}, rows)["budget"]
        # Lower quartile, minimum, maximum, upper quartile, median, as gnuplot's candlesticks take them.
        self.assertIn("$boxes3 << EOD\n40 200 100 500 400 300\n60 2 2 2 2 2\nEOD\n", picture.script)
        self.assertIn("set xrange [32:68]", picture.script)
        self.assertIn("title 'A, 5 runs'", picture.script)
        self.draw(picture)

    def test_one_run_without_relative_errors_has_a_picture(self):
        rows = [tracking_row("A", 0, selector, 1, None, None, budget)
                for selector, budget in (("md", 20.0), ("inl", 0.0), ("all_weighted", 0.0))]
        for picture in (*tracking.budget({}, rows).values(), *tracking.euroc({}, rows).values()):
            self.assertNotIn("RPE", picture.script)
            self.draw(picture)


class Epsilon(PictureTest):
    def test_cells_are_means_over_runs(self):
        settings = {"sizes": [60, 100], "shares": [0.1, 0.5], "epsilons": [1, 0.05]}
        rows = []
        for run in (0.0, 1.0):
            for n in (60.0, 100.0):
                for i in range(4):
                    rows.append({"run": run, "n": n, "k": 10.0, "us": 8 + i + 2 * run, "gap_nats": 0.1 * i, "differing": i})
        pictures = epsilon.pictures(settings, rows)
        self.assertEqual(list(pictures), ["epsilon_time", "epsilon_gap", "epsilon_differing"])
        time = pictures["epsilon_time"]
        self.assertIn("$map1 << EOD\n0 0 9 9.0\n0 1 10 10\n1 0 11 11\n1 1 12 12\nEOD\n", time.script)
        self.assertIn("set ytics ('1' 0, '0.05' 1)", time.script)
        self.assertIn("1 1 30 30\n", pictures["epsilon_differing"].script, "per cent")
        for picture in pictures.values():
            self.draw(picture)


class Metrics(PictureTest):
    def test_curves_are_in_order_of_size(self):
        settings = {"noises_px": [1, 2], "weightings": ["measurement", "map_bias"]}
        rows = [{"noise_px": float(noise), "size": size, "weighting": weighting, "selector": selector, "runs": 4.0,
                 "rms_translation_m": size / 100, "ci95_translation_m": 0.01, "rms_rotation_deg": 1.0,
                 "ci95_rotation_deg": None}
                for weighting in settings["weightings"] for noise in (1, 2) for size in (30.0, 15.0)
                for selector in ("max_log_det", "all")]
        pictures = metrics.pictures(settings, rows)
        self.assertEqual(list(pictures), ["metrics_measurement", "metrics_map_bias"])
        script = pictures["metrics_map_bias"].script
        self.assertIn("$all_1 << EOD\n15 0.15 0.01 1 NaN\n30 0.3 0.01 1 NaN\nEOD\n", script)
        self.assertIn("map_bias blocks, 4 runs", script)
        self.assertIn("set title 'noise 2 px'", script)
        for picture in pictures.values():
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
