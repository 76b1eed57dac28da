# SPDX-License-Identifier: MIT
"""Errors: exceptions name what is wrong, and nothing is selected."""
import pickle
import re

import numpy as np
import pytest

import maxlogdet

BLOCKS = np.random.default_rng(5).normal(size=(20, 2, 6))
MASK = np.zeros(20, bool)

REFUSED = [
    ("capacity_exceeded", dict(blocks=np.ones((41, 1, 6)))),
    ("invalid_epsilon", dict(strategy="stochastic_greedy", epsilon=1.0)),
    ("invalid_epsilon", dict(strategy="stochastic_greedy", epsilon=float("nan"))),
    ("invalid_prior", dict(prior=np.zeros((6, 6)))),
    ("invalid_prior", dict(prior=np.triu(np.ones((6, 6))) + np.eye(6))),
    ("invalid_prior", dict(prior=np.full((6, 6), np.inf))),
    ("invalid_time_limit", dict(time_limit=-1)),
    ("invalid_time_limit", dict(time_limit=float("nan"))),
    ("invalid_threads", dict(threads=-1)),
    ("invalid_threads", dict(threads=-(10**30))),
    ("invalid_groups", dict(groups=np.full(20, 2), group_maxima=[1, 1])),
    ("invalid_groups", dict(groups=np.zeros(20, int), group_maxima=[])),
    ("infeasible", dict(required=~MASK, budget=19)),
    ("infeasible", dict(required=~MASK, excluded=~MASK)),
    ("infeasible", dict(required=~MASK, groups=np.zeros(20, int))),
    ("unsupported_groups", dict(strategy="relaxed", groups=np.zeros(20, int))),
    ("invalid_target", dict(target_efficiency=1.01)),
    ("invalid_target", dict(target_translation_sigma=-1e-3)),
    ("invalid_target", dict(target_rotation_sigma=float("nan"))),
    ("invalid_target", dict(target_rotation_sigma=float("inf"))),
    ("unsupported_target", dict(strategy="backward_greedy", target_efficiency=0.5)),
    ("unsupported_target", dict(strategy="relaxed", target_rotation_sigma=0.5)),
    ("unsupported_target", dict(exchange_sweeps=1, target_translation_sigma=0.5)),
]


@pytest.mark.parametrize("reason, wrong", REFUSED)
def test_refusals_carry_their_reason(reason, wrong):
    selector = maxlogdet.Selector(40)
    arguments = {"blocks": BLOCKS, "budget": 20, **wrong}
    with pytest.raises(maxlogdet.SelectionError, match=f"^{reason}: {re.escape(maxlogdet.errors[reason])}$") as error:
        selector.select(**arguments)
    assert isinstance(error.value, ValueError)
    assert error.value.error == reason
    assert pickle.loads(pickle.dumps(error.value)).error == reason
    assert len(selector.select(BLOCKS, 20)) == 20  # the selector still works


ARGUMENTS = [
    (ValueError, r"blocks: expected shape \(n, r, 6\), got \(20, 2, 5\)", dict(blocks=BLOCKS[:, :, :5])),
    (ValueError, r"blocks: expected shape \(n, r, 6\) with r in \{1, 2, 3\}", dict(blocks=np.ones((20, 4, 6)))),
    (ValueError, r"blocks: expected shape \(n, r, 6\) with r in \{1, 2, 3\}", dict(blocks=np.ones((20, 0, 6)))),
    (TypeError, "blocks: expected an array of floats, got complex128", dict(blocks=BLOCKS * 1j)),
    (TypeError, "blocks: expected an array of floats, got object", dict(blocks=None)),
    (TypeError, "blocks: expected an array of floats, got bool", dict(blocks=BLOCKS > 0)),
    (TypeError, "blocks: expected an array of floats, got datetime64", dict(blocks=np.zeros((1, 1, 6), "M8[s]"))),
    (TypeError, r"blocks\[0\]: expected an array of floats", dict(blocks=[[[1, 2], [3]]])),
    (ValueError, "budget: expected an integer in ", dict(budget=-1)),
    (ValueError, "budget: expected an integer in ", dict(budget=2**64)),
    (TypeError, "budget: expected an integer, got <class 'float'>", dict(budget=10.0)),
    (TypeError, "budget: expected an integer, got <class 'NoneType'>", dict(budget=None)),
    (ValueError, "seed: expected an integer in ", dict(seed=-1)),
    (ValueError, "strategy: expected one of 'greedy', .* got 'lazy'", dict(strategy="lazy")),
    (TypeError, "strategy: expected a string", dict(strategy=1)),
    (TypeError, "epsilon: expected a number", dict(epsilon="0.1")),
    (TypeError, "time_limit: expected a number", dict(time_limit=None)),
    (TypeError, "certificate: expected True or False", dict(certificate=1)),
    (TypeError, "threads: expected an integer", dict(threads=1.5)),
    (ValueError, r"prior: expected shape \(6, 6\), got \(3, 3\)", dict(prior=np.eye(3))),
    (TypeError, "prior: expected an array of floats", dict(prior=np.eye(6) * 1j)),
    (ValueError, r"required: expected shape \(20,\), got \(19,\)", dict(required=MASK[1:])),
    (TypeError, "required: expected an array of bools", dict(required=[3, 4])),
    (TypeError, "excluded: expected an array of bools", dict(excluded=MASK.astype(np.uint8))),
    (ValueError, r"groups: expected shape \(20,\)", dict(groups=[1])),
    (TypeError, "groups: expected an array of integers, got float64", dict(groups=np.zeros(20))),
    (TypeError, "groups: expected an array of integers, got bool", dict(groups=MASK)),
    (TypeError, "group_maxima: expected an array of integers, got bool", dict(groups=MASK + 0, group_maxima=[True])),
    (ValueError, r"groups: expected integers in \[0, 2\^32\)", dict(groups=np.full(20, -1))),
    (ValueError, r"groups: expected integers in \[0, 2\^32\)", dict(groups=np.full(20, 2**64 - 1, np.uint64))),
    (ValueError, "group_maxima: expected groups as well", dict(group_maxima=[1])),
    (TypeError, "unexpected keyword argument 'bugdet'", dict(bugdet=1)),
]


@pytest.mark.parametrize("error, text, wrong", ARGUMENTS)
def test_messages_name_the_wrong_argument(error, text, wrong):
    for select in (maxlogdet.select_blocks, maxlogdet.Selector(20).select):
        with pytest.raises(error, match=text) as raised:
            select(**{"blocks": BLOCKS, "budget": 20, **wrong})
        assert type(raised.value) is error
        assert "\n" not in str(raised.value)


@pytest.mark.parametrize("true", [True, np.bool_(True)])
def test_a_bool_is_no_integer(true):
    active = maxlogdet.ActiveSelection(20)
    active.start(BLOCKS, 20)
    proposal = active.next()
    calls = [(name, lambda name=name: maxlogdet.select_blocks(BLOCKS, **{name: true}))
             for name in ("budget", "seed", "threads", "certificate_passes", "exchange_sweeps", "group_maximum")]
    calls += [
        ("capacity", lambda: maxlogdet.Selector(true)),
        ("threads", lambda: maxlogdet.Selector(20, threads=true)),
        ("capacity", lambda: maxlogdet.ActiveSelection(true)),
        ("capacity", lambda: maxlogdet.BlockStore(true)),
        ("capacity", lambda: maxlogdet.BlockStore(capacity=true)),
        ("capacity", lambda: maxlogdet.BlockStore().reserve(true)),
        ("threads", lambda: maxlogdet.BlockStore().append_blocks(
            maxlogdet.PinholeCamera(1, 1), np.eye(4), np.ones((1, 3)), threads=true)),
        ("budget", lambda: maxlogdet.ActiveSelection(20).start(BLOCKS, true)),
        ("count", lambda: active.next_batch(true)),
        ("index", lambda: active.accept(index=true)),
        ("index", lambda: active.reject(index=true)),
    ]
    for name, call in calls:
        with pytest.raises(TypeError, match=f"^{name}: expected an integer, got <class '(numpy.)?bool_?'>$"):
            call()
    assert active.next() == proposal  # still unanswered
    active.accept(index=np.uint32(proposal))


def test_every_error_is_explained():
    assert maxlogdet.errors["none"] == "nothing is wrong"
    assert {reason for reason, _ in REFUSED} <= set(maxlogdet.errors)
    assert all(text and "\n" not in text for text in maxlogdet.errors.values())


def test_none_means_the_default():
    arrays = dict.fromkeys(["prior", "required", "excluded", "groups", "group_maxima", "threads"])
    assert maxlogdet.select_blocks(BLOCKS, 5, **arrays).indices.tolist() == maxlogdet.select_blocks(BLOCKS, 5).indices.tolist()


def test_numbers_may_come_from_numpy():
    expected = maxlogdet.select_blocks(BLOCKS, 5).indices.tolist()
    selection = maxlogdet.Selector(np.int64(20), np.int8(1)).select(
        BLOCKS, np.uint16(5), time_limit=np.float32(9), group_maximum=np.int64(3), certificate_passes=np.uint8(2))
    assert selection.indices.tolist() == expected


def test_a_capacity_beyond_memory_raises_memory_error():
    for make in (lambda: maxlogdet.Selector(2**40), lambda: maxlogdet.ActiveSelection(2**62),
                 lambda: maxlogdet.GoodFeatures(2**32), lambda: maxlogdet.GoodFeatures(2**63),
                 lambda: maxlogdet.BlockStore(capacity=2**63)):
        with pytest.raises(MemoryError):
            make()


def test_an_exception_in_index_becomes_a_type_error():
    class Broken:
        def __index__(self):
            raise KeyError("within")

    with pytest.raises(TypeError, match="budget"):
        maxlogdet.select_blocks(BLOCKS, Broken())
