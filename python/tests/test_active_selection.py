# SPDX-License-Identifier: MIT
"""Active selection: proposals, answers, and the store that it keeps unchanged."""
import gc

import numpy as np
import pytest

import maxlogdet
from oracle import check_greedy, pinhole_blocks


def test_accepting_everything_is_lazy_greedy(rng):
    blocks = pinhole_blocks(rng, 300)
    expected = maxlogdet.select_blocks(blocks, 40)
    active = maxlogdet.ActiveSelection(300)
    active.start(blocks, 40)
    proposed = []
    for i in active:
        assert active.next() == i  # until it is answered
        proposed.append(i)
        active.accept()
    assert active.next() is None
    selection = active.selection()
    assert proposed == expected.indices.tolist() == selection.indices.tolist()
    assert selection.log_det == expected.log_det
    assert np.array_equal(selection.gains, expected.gains)


def test_a_rejected_candidate_is_not_proposed_again(rng):
    blocks = rng.normal(size=(100, 2, 6))
    is_matched = rng.random(100) < 0.5
    active = maxlogdet.ActiveSelection(100)
    active.start(blocks, 20)
    proposed, rejected = [], []
    for i in active:
        proposed.append(i)
        if is_matched[i]:
            active.accept()
        else:
            active.reject()
            rejected.append(i)
    selection = active.selection()
    assert len(set(proposed)) == len(proposed)
    assert len(selection) == 20 and is_matched[selection.indices].all()
    check_greedy(blocks, selection.indices, allowed=np.isin(np.arange(100), rejected, invert=True))


def test_a_measured_block_replaces_the_proposed_one(rng):
    blocks = rng.normal(size=(50, 2, 6))
    measured = rng.normal(size=(3, 6))
    active = maxlogdet.ActiveSelection(50)
    active.start(blocks, 2)
    active.next()
    with pytest.raises(ValueError, match=r"block: expected shape \(r, 6\)"):
        active.accept(np.zeros((4, 6)))
    with pytest.raises(maxlogdet.SelectionError) as error:
        active.accept(np.full((2, 6), np.nan))
    assert error.value.error == "invalid_block"
    assert active.next() is not None  # still proposed
    active.accept(measured)
    rounded = measured.astype(np.float32).astype(float)
    expected = np.linalg.slogdet(1e-5 * np.eye(6) + rounded.T @ rounded)[1]
    assert active.selection().log_det == pytest.approx(expected, abs=1e-6)


def test_constraints_hold(rng):
    blocks = rng.normal(size=(60, 2, 6))
    required, excluded = np.zeros(60, bool), np.zeros(60, bool)
    required[50], excluded[10:40] = True, True
    groups = np.arange(60) % 7
    active = maxlogdet.ActiveSelection(60)
    active.start(blocks, 60, required=required, excluded=excluded, groups=groups, group_maximum=2)
    for _ in active:
        active.accept()
    selection = active.selection()
    assert selection.indices[0] == 50 and not excluded[selection.indices].any()
    assert np.bincount(groups[selection.indices]).max() == 2
    assert selection.status == "all_selected"


def test_arrays_may_be_freed_or_changed_after_start(rng):
    blocks = rng.normal(size=(200, 2, 6))
    groups, maxima, excluded = rng.integers(0, 20, 200), np.full(20, 3), rng.random(200) < 0.3
    prior = 100 * np.eye(6)
    options = dict(groups=groups, group_maxima=maxima, excluded=excluded, prior=prior)
    expected = maxlogdet.select_blocks(blocks, 40, **options).indices.tolist()
    active = maxlogdet.ActiveSelection(200)
    active.start(maxlogdet.BlockStore(blocks), 40, **options)  # no other reference to that store
    for array in (groups, maxima, excluded, prior, blocks):
        array[...] = 10**6
    del options, groups, maxima, excluded, prior, blocks
    gc.collect()
    for _ in active:
        active.accept()
    assert active.selection().indices.tolist() == expected


def test_a_store_cannot_change_while_an_active_selection_uses_it(rng):
    store = maxlogdet.BlockStore(rng.normal(size=(30, 2, 6)))
    active = maxlogdet.ActiveSelection(100)

    def refused():
        try:
            store.append(None)
        except BufferError:
            return True
        return False

    active.start(store, 5)
    assert refused()
    for _ in active:
        active.accept()
    assert refused()  # selection() still works
    active.stop()
    assert not refused()
    with active:
        active.start(store, 5)
        assert refused()
    assert not refused()
    active.start(store, 5)
    active.start(rng.normal(size=(30, 2, 6)), 5)
    assert not refused()
    active.start(store, 5)
    with pytest.raises(maxlogdet.SelectionError, match="capacity_exceeded"):
        active.start(np.ones((101, 1, 6)))
    assert not refused()
    active.start(store, 5)
    del active
    gc.collect()
    assert not refused()


def test_other_selections_may_use_the_store_meanwhile(rng):
    store = maxlogdet.BlockStore(rng.normal(size=(30, 2, 6)))
    first, second = maxlogdet.ActiveSelection(30), maxlogdet.ActiveSelection(30)
    first.start(store, 5)
    second.start(store, 5)
    assert first.next() == second.next() == maxlogdet.select_blocks(store, 5).indices[0]


def test_an_answer_without_a_proposal_is_an_error(rng):
    active = maxlogdet.ActiveSelection(30)

    def error_of(call):
        with pytest.raises(maxlogdet.SelectionError) as error:
            call()
        return error.value.error

    def all_errors():
        return {error_of(call) for call in (active.accept, active.reject, lambda: active.accept(np.ones((2, 6))))}

    assert active.next() is None and list(active) == []
    assert all_errors() == {"nothing_proposed"}
    assert error_of(active.selection) == "nothing_proposed"
    active.start(rng.normal(size=(30, 2, 6)), 5)
    assert all_errors() == {"nothing_proposed"}  # next() has not been called
    assert len(active.selection()) == 0
    active.next()
    active.stop()
    assert all_errors() == {"nothing_proposed"}
    assert active.next() is None


def test_an_unanswered_proposal_ends_an_iteration_with_an_error(rng):
    active = maxlogdet.ActiveSelection(30)
    active.start(rng.normal(size=(30, 2, 6)), 5)
    with pytest.raises(RuntimeError, match=r"accept\(\) or reject\(\)"):
        for _ in active:
            pass
    active.accept()  # iteration may go on after an answer
    assert len(active.selection()) == 1


def test_a_batch_has_the_highest_current_gains(rng):
    blocks = rng.normal(size=(100, 2, 6))
    active = maxlogdet.ActiveSelection(100)
    active.start(blocks, 20)
    information = 1e-5 * np.eye(6)
    is_open = np.ones(100, bool)
    while len(batch := active.next_batch(7)) > 0:
        assert batch.dtype == np.uint32
        assert len(batch) == min(7, 20 - len(active.selection()))
        stored = blocks.astype(np.float32).astype(float)
        gains = np.linalg.slogdet(information + np.swapaxes(stored, 1, 2) @ stored)[1]
        best = np.flatnonzero(is_open)[np.argsort(-gains[is_open])]
        assert batch.tolist() == best[:len(batch)].tolist()
        matched = rng.random(len(batch)) < 0.5
        active.answer(matched)
        is_open[batch] = False
        for i in batch[matched]:
            information += stored[i].T @ stored[i]
    selection = active.selection()
    assert len(selection) == 20
    assert selection.log_det == pytest.approx(np.linalg.slogdet(information)[1], abs=1e-9)


def test_answers_by_index_may_come_in_any_order(rng):
    active = maxlogdet.ActiveSelection(50)
    active.start(rng.normal(size=(50, 2, 6)), 10)
    batch = active.next_batch(5)
    assert active.next() == batch[0]
    assert active.next_batch(100).tolist() == batch.tolist()
    active.accept(index=batch[3])
    active.reject(index=int(batch[0]))
    active.accept(rng.normal(size=(1, 6)), index=batch[4])
    assert active.next_batch(10).tolist() == batch[1:3].tolist()
    for index in (batch[0], 50, 2**32 - 1, 2**32 + int(batch[1]), 2**70 // 2**7):
        with pytest.raises(maxlogdet.SelectionError) as error:
            active.reject(index=index)
        assert error.value.error == "nothing_proposed"
    with pytest.raises(RuntimeError, match=r"accept\(\) or reject\(\)"):
        next(iter(active))
    active.answer([False, True])
    assert active.selection().indices.tolist() == batch[[3, 4, 2]].tolist()
    assert next(iter(active)) not in batch


def test_malformed_answers_to_batches_are_refused(rng):
    active = maxlogdet.ActiveSelection(50)

    def refused(call, error, text):
        with pytest.raises(error, match=text):
            call()

    refused(lambda: active.answer([True]), maxlogdet.SelectionError, "nothing_proposed")
    active.start(rng.normal(size=(50, 2, 6)), 10)
    refused(lambda: active.answer([]), maxlogdet.SelectionError, "nothing_proposed")
    assert len(active.next_batch(0)) == 0
    batch = active.next_batch(3).tolist()
    refused(lambda: active.answer([True] * 2), ValueError, r"matched: expected shape \(3,\)")
    refused(lambda: active.answer([0, 1, 2]), TypeError, "matched: expected an array of bools")
    refused(lambda: active.answer(None), TypeError, "matched")
    refused(lambda: active.next_batch(-1), ValueError, "count")
    refused(lambda: active.next_batch(None), TypeError, "count: expected an integer")
    refused(lambda: active.accept(index=1.5), TypeError, "index: expected an integer")
    refused(lambda: active.reject(index=-1), ValueError, "index")
    assert active.next_batch(2**63).tolist() == batch
    active.stop()
    assert len(active.next_batch(3)) == 0
    refused(lambda: active.reject(index=batch[0]), maxlogdet.SelectionError, "nothing_proposed")
    active.start(rng.normal(size=(50, 2, 6)), 10)
    assert len(active.next_batch(2**63)) == 10


def test_a_time_limit_ends_the_proposals(rng):
    active = maxlogdet.ActiveSelection(30)
    active.start(rng.normal(size=(30, 2, 6)), 5, time_limit=1e-9)
    assert active.next() is None
    assert active.selection().status == "deadline_reached"


def test_targets_end_the_proposals(rng):
    blocks = rng.normal(size=(300, 2, 6))
    expected = maxlogdet.select_blocks(blocks, 200, target_efficiency=0.2)
    active = maxlogdet.ActiveSelection(300)
    active.start(blocks, 200, target_efficiency=0.2)
    for _ in active:
        assert active.selection().status == "ok"
        active.accept()
    selection = active.selection()
    assert selection.status == "target_reached"
    assert np.array_equal(selection.indices, expected.indices)
    assert selection.efficiency == expected.efficiency
    active.start(blocks, 200, target_translation_sigma=0.3)
    batch = active.next_batch(150)
    active.answer(np.ones(len(batch), bool))  # also those after the target is met: they are matched
    assert active.next() is None
    assert len(active.selection()) == 150 and active.selection().translation_sigma < 0.3


@pytest.mark.parametrize("options, error, text", [
    (dict(strategy="relaxed"), maxlogdet.SelectionError, "invalid_strategy"),
    (dict(certificate=True), TypeError, "unexpected keyword argument 'certificate'"),
    (dict(threads=1), TypeError, "unexpected keyword argument 'threads'"),
    (dict(prior=-np.eye(6)), maxlogdet.SelectionError, "invalid_prior"),
])
def test_start_refuses_wrong_arguments(rng, options, error, text):
    active = maxlogdet.ActiveSelection(200)
    with pytest.raises(error, match=text):
        active.start(rng.normal(size=(30, 2, 6)), **options)
    assert active.next() is None
