# SPDX-License-Identifier: MIT
"""Tries mutants: each worker compiles them in a copy of the sources and runs the tests."""

import collections
import hashlib
import json
import os
import shutil
import subprocess
import threading
import time

from maxlogdet_tools.project import ROOT
from mutants import key

WORK = ROOT / "build/mutate"
TARGETS = ["maxlogdet_tests", "maxlogdet_threading_tests", "maxlogdet_real_time_tests"]
# A quick stage kills most mutants within seconds; the others run all repetitions, and narrower instruction sets.
QUICK = {"MAXLOGDET_TEST_SHARE": "0.05"}
SECONDS_TO_COMPILE = 600


class Worker:
    """A copy of the sources and a build of it."""

    def __init__(self, number):
        self.source = WORK / f"worker{number}" / ROOT.name
        self.build = WORK / f"worker{number}" / "build"

    def run(self, command, seconds, **environment):
        with subprocess.Popen(command, cwd=self.source, env={**os.environ, **environment}, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, start_new_session=True) as process:
            try:
                return process.wait(seconds)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, 9)
                return None

    def prepare(self):
        for folder in (self.source, self.build):  # an interrupted run may have left a mutant
            if folder.exists():
                shutil.rmtree(folder)
        shutil.copytree(ROOT, self.source, ignore=shutil.ignore_patterns("build", ".git"))
        status = self.run(["cmake", "-S", ".", "-B", str(self.build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                           "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG", "-DMAXLOGDET_BUILD_BENCHMARKS=OFF",
                           "-DMAXLOGDET_BUILD_PYTHON=OFF", f"-DMAXLOGDET_DEFAULT_DATA={WORK}/no_real_frames"], 600)
        if status == 0:
            status = self.compile()
        if status != 0:
            raise RuntimeError("the sources do not build without any mutation; try ci/test")
        self.objects = self.hash_of_objects()
        self.seconds = {}
        for stage in self.stages():
            start = time.monotonic()
            if self.run_stage(stage, 3600) != 0:
                raise RuntimeError(f"{stage[0]} fails without any mutation; try ci/test")
            self.seconds[stage[0]] = 20 + 4 * (time.monotonic() - start)

    def compile(self):
        return self.run(["cmake", "--build", str(self.build), "-j1", "--target", *TARGETS], SECONDS_TO_COMPILE)

    def hash_of_objects(self):
        """The hash of all objects, which are built without debug information: that would depend on line numbers."""
        total = hashlib.sha256()
        for file in sorted(self.build.rglob("*.a")) + sorted((self.build / "tests").rglob("*.o")):
            total.update(file.read_bytes())
        return total.digest()

    def stages(self):
        tests = self.build / "tests"
        core = [str(tests / "maxlogdet_tests"), "--gtest_fail_fast"]
        threads = [str(tests / "maxlogdet_threading_tests"), "--gtest_fail_fast"]
        yield "core, quick", core, QUICK
        yield "real time", [str(tests / "maxlogdet_real_time_tests"), "--gtest_fail_fast"], QUICK
        yield "threads, quick", threads, QUICK
        for isa in ("sse2", "avx2"):
            yield f"core on {isa}, quick", [*core, "--gtest_filter=-Isa.*"], {**QUICK, "MAXLOGDET_ISA": isa}
        yield "core", core, {}
        yield "threads", threads, {}

    def run_stage(self, stage, seconds):
        _, command, environment = stage
        return self.run(command, seconds, **environment)

    def try_out(self, mutant):
        path = self.source / mutant["file"]
        original = path.read_text()
        lines = original.split("\n")
        lines[mutant["line"] - 1] = mutant["text"]
        path.write_text("\n".join(lines))
        try:
            if self.compile() != 0:
                return "does not compile", None
            if self.hash_of_objects() == self.objects:
                return "same code", None
            for stage in self.stages():
                status = self.run_stage(stage, self.seconds[stage[0]])
                if status != 0:
                    return "killed", stage[0] + (": hangs" if status is None else "")
            return "survived", None
        finally:
            path.write_text(original)


def read_results():
    file = WORK / "results.jsonl"
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def try_all(mutants, jobs):
    """Tries the mutants of one file after the other, because restoring a file recompiles what depends on it."""
    WORK.mkdir(parents=True, exist_ok=True)
    known = {(key(r), r["line"]) for r in read_results()}
    left = [m for m in mutants if (key(m), m["line"]) not in known]
    queue = collections.deque(sorted(left, key=lambda m: (m["file"], m["line"])))
    total, done, lock, start = len(queue), 0, threading.Lock(), time.monotonic()

    def work(number):
        nonlocal done
        if not queue:
            return
        worker = Worker(number)
        worker.prepare()
        while True:
            with lock:
                if not queue:
                    return
                mutant = queue.popleft() if number % 2 == 0 else queue.pop()
            outcome, by = worker.try_out(mutant)
            with lock:
                done += 1
                result = {k: v for k, v in mutant.items() if k != "text"} | {"outcome": outcome, "by": by}
                with (WORK / "results.jsonl").open("a") as file:
                    file.write(json.dumps(result) + "\n")
                minutes = (time.monotonic() - start) / 60
                print(f"{done} of {total}, {minutes:.0f} min: {mutant['file']}:{mutant['line']} {outcome}"
                      f"{' by ' + by if by else ''}", flush=True)

    workers = [threading.Thread(target=work, args=(n,)) for n in range(jobs)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
