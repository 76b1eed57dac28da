# SPDX-License-Identifier: MIT
"""Which runs of bench/run how_fast are too noisy to publish."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

RESULTS = pathlib.Path(__file__).resolve().parents[2] / "bench/how_fast/results.py"


def blocks_of(name, times):
    """The blocks of a case, which took these times, us, in this order; Google Benchmark does not keep to it."""
    blocks = [{"run_name": name, "run_type": "iteration", "repetition_index": i, "real_time": time, "calls": i}
              for i, time in enumerate(times)]  # fmt: skip
    return blocks[::-1]


def judged(baseline, *others):
    """The exit code and the message of results.py."""
    blocks = blocks_of("baseline/eigen/iterations:1", baseline) if baseline else []
    for i, times in enumerate(others):
        blocks += blocks_of(f"grid/greedy/n:{i}", times)
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump({"context": {"maxlogdet_isa": "avx2"}, "benchmarks": blocks}, file)
        file.flush()
        result = subprocess.run([sys.executable, RESULTS, file.name], capture_output=True, text=True)
    return result.returncode, result.stderr


STEADY = [100, 100, 100, 200, 100, 100, 200, 100]
LATER_SLOWER = [100] * 4 + [106] * 4
REFUSED = (1, "too noisy to publish: the two halves of the run differ by 6 %, expected at most 5 %\n")


class Noise(unittest.TestCase):
    def test_a_steady_run_may_be_published(self):
        for baseline in (STEADY, [100] * 4 + [104] * 4):
            self.assertEqual(judged(baseline, STEADY, LATER_SLOWER), (0, ""))

    def test_a_run_may_not_whose_baseline_changed(self):
        for baseline in (LATER_SLOWER, LATER_SLOWER[::-1]):
            self.assertEqual(judged(baseline, STEADY, STEADY), REFUSED)

    def test_a_run_may_not_in_which_half_of_the_cases_changed(self):
        self.assertEqual(judged(STEADY, LATER_SLOWER, LATER_SLOWER[::-1]), REFUSED)

    def test_a_run_may_not_that_has_no_baseline(self):
        code, message = judged([], STEADY)
        self.assertEqual(code, 1)
        self.assertIn("expected the case baseline/eigen_lazy_scan", message)


if __name__ == "__main__":
    unittest.main()
