# SPDX-License-Identifier: MIT
"""Which runs of bench/run how_fast are too noisy to publish."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

RESULTS = pathlib.Path(__file__).resolve().parents[2] / "bench/how_fast/results.py"


def judged(times):
    """What results.py says of a run whose baseline took these times, us, in the order of the blocks."""
    blocks = [{"run_name": "baseline/eigen/iterations:1", "run_type": "iteration", "repetition_index": i, "real_time": time,
               "calls": i} for i, time in enumerate(times)]  # fmt: skip
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        # Google Benchmark writes no order of its own.
        json.dump({"context": {"maxlogdet_isa": "avx2"}, "benchmarks": blocks[::-1]}, file)
        file.flush()
        return subprocess.run([sys.executable, RESULTS, file.name], capture_output=True, text=True)


class Noise(unittest.TestCase):
    def test_a_steady_baseline_may_be_published(self):
        for times in ([100] * 8, [100, 100, 100, 200, 100, 100, 200, 100], [100] * 4 + [104] * 4):
            result = judged(times)
            self.assertEqual((result.returncode, result.stderr), (0, ""), times)

    def test_halves_that_differ_may_not(self):
        for times in ([100] * 4 + [106] * 4, [106] * 4 + [100] * 4):
            result = judged(times)
            self.assertEqual(result.returncode, 1)
            self.assertEqual(result.stderr, "too noisy to publish: the baseline's two halves differ by 6 %, expected at "
                                            "most 5 %\n")  # fmt: skip

    def test_a_run_without_the_baseline_may_not(self):
        result = judged([])
        self.assertEqual(result.returncode, 1)
        self.assertIn("expected the case baseline/eigen_lazy_scan", result.stderr)


if __name__ == "__main__":
    unittest.main()
