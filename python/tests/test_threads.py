# SPDX-License-Identifier: MIT
"""Threads of Python and of oneTBB, and instruction sets."""
import concurrent.futures
import os
import subprocess
import sys
import threading

import numpy as np
import pytest

import maxlogdet
from oracle import pinhole_blocks


def test_other_python_threads_run_meanwhile_but_cannot_share_the_selector(rng):
    """While one thread selects for about a second, this one tries the same selector and a selector of its own."""
    large = maxlogdet.BlockStore(rng.normal(size=(50000, 2, 6)))
    small = rng.normal(size=(50, 2, 6))
    expected = maxlogdet.select_blocks(small, 5).indices.tolist()
    shared, own = maxlogdet.Selector(50000), maxlogdet.Selector(50)
    answers = []

    def work():
        while not answers:
            try:
                answers.append(shared.select(large, 20000, strategy="greedy", threads=1, time_limit=20))
            except RuntimeError:  # the other thread was first
                pass

    worker = threading.Thread(target=work)
    worker.start()
    refused, changed, beside = 0, 0, 0
    while worker.is_alive():
        try:
            shared.select(small, 5)
        except RuntimeError as error:
            assert "selecting in another thread" in str(error)
            refused += 1
            assert own.select(small, 5).indices.tolist() == expected
            beside += 1
            try:
                large.append(None)
            except BufferError:
                changed += 1
    worker.join()
    assert refused > 0 and beside > 0
    assert changed > 0  # a store in use did not change
    assert len(answers[0]) > 0
    assert shared.select(small, 5).indices.tolist() == expected


def test_several_selectors_may_use_one_store_at_once(rng):
    store = maxlogdet.BlockStore(pinhole_blocks(rng, 3000))
    expected = maxlogdet.select_blocks(store, 50).indices.tolist()

    def many(_):
        selector = maxlogdet.Selector(3000)
        return [selector.select(store, 50).indices.tolist() for _ in range(20)]

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        for answers in pool.map(many, range(4)):
            assert all(answer == expected for answer in answers)
    store.append(None)  # no selection uses it any more


@pytest.mark.parametrize("strategy", maxlogdet.strategies)
def test_the_answer_does_not_depend_on_threads(rng, strategy):
    n, k = (3000, 2800) if strategy == "backward_greedy" else (20000, 60)
    store = maxlogdet.BlockStore(pinhole_blocks(rng, n))
    one = maxlogdet.Selector(n, threads=1).select(store, k, strategy=strategy)
    assert one.threads == 1
    for threads in (0, 2, 16):
        other = maxlogdet.Selector(n).select(store, k, strategy=strategy, threads=threads)
        assert np.array_equal(other.indices, one.indices)
        assert np.array_equal(other.gains, one.gains) and other.log_det == one.log_det


def test_helpers_work_where_there_are_some(rng):
    assert maxlogdet.has_tbb == (os.environ.get("MAXLOGDET_HAS_TBB", str(int(maxlogdet.has_tbb))) == "1")
    blocks = rng.normal(size=(1000, 2, 6))
    processors = len(os.sched_getaffinity(0))
    expected = 2 if maxlogdet.has_tbb and processors > 1 else 1
    assert maxlogdet.select_blocks(blocks, 10, threads=2).threads == expected
    assert maxlogdet.Selector(1000, threads=2).select(blocks, 10).threads == expected
    assert maxlogdet.Selector(1000, threads=2).select(blocks, 10, threads=1).threads == 1
    assert maxlogdet.Selector(1000).select(blocks, 10).threads == 1  # threads do not pay for so few


CHILD = """
import sys, numpy as np, maxlogdet
blocks = np.load(sys.argv[1])
print(maxlogdet.isa())
if maxlogdet.isa() != 'none':
    for strategy in ('lazy_greedy', 'stochastic_greedy', 'backward_greedy'):
        s = maxlogdet.select_blocks(blocks, 200, strategy=strategy)
        print(s.indices.tolist(), s.gains.tobytes().hex(), s.log_det.hex())
else:
    try:
        maxlogdet.select_blocks(blocks, 200)
    except maxlogdet.SelectionError as error:
        print(error.error)
"""


def in_child(path, isa):
    environment = {**os.environ, "MAXLOGDET_ISA": isa}
    run = subprocess.run([sys.executable, "-B", "-c", CHILD, path], env=environment, text=True, capture_output=True)
    assert run.returncode == 0, run.stderr
    return run.stdout.splitlines()


def test_the_answer_does_not_depend_on_the_instruction_set(rng, tmp_path):
    path = str(tmp_path / "blocks.npy")
    np.save(path, pinhole_blocks(rng, 1000, 3))
    expected = in_child(path, "")
    compared = []
    for isa in maxlogdet.isas:
        name, *answers = in_child(path, isa)
        if name == "none":  # this machine lacks it
            assert answers == ["unsupported_isa"]
            continue
        assert name == isa
        assert answers == expected[1:]
        compared.append(isa)
    print("compared:", compared)
    assert expected[0] in compared


def test_an_unknown_instruction_set_is_an_error(rng, tmp_path):
    path = str(tmp_path / "blocks.npy")
    np.save(path, rng.normal(size=(300, 2, 6)))
    assert in_child(path, "mmx") == ["none", "unsupported_isa"]
