# SPDX-License-Identifier: MIT
"""Selections, compared with an oracle in NumPy."""
import itertools

import numpy as np
import pytest

import maxlogdet
from oracle import check_greedy, information, log_det, pinhole_blocks

ROWS = [1, 2, 3]


@pytest.mark.parametrize("rows", ROWS)
@pytest.mark.parametrize("trial", range(4))
@pytest.mark.parametrize("strategy", ["greedy", "lazy_greedy"])
def test_greedy_takes_the_best_in_every_round(rng, rows, trial, strategy):
    blocks = pinhole_blocks(rng, 150, rows) if trial % 2 else rng.normal(size=(150, rows, 6))
    selection = maxlogdet.select_blocks(blocks, 30, strategy=strategy)
    assert selection.status == "ok"
    assert selection.strategy == strategy
    assert len(set(selection.indices)) == 30
    assert check_greedy(blocks, selection.indices) > 15  # nearly all rounds have one clear winner
    assert selection.log_det == pytest.approx(log_det(information(blocks, selection.indices)), abs=1e-6)


def test_gains_add_up_to_log_det(rng):
    blocks = pinhole_blocks(rng, 400)
    selection = maxlogdet.select_blocks(blocks, 60)
    assert selection.gains.shape == (60,)
    assert 6 * np.log(1e-5) + selection.gains.sum() == pytest.approx(selection.log_det, abs=1e-9)
    for size in (1, 10, 60):
        expected = log_det(information(blocks, selection.indices[:size]))
        assert 6 * np.log(1e-5) + selection.gains[:size].sum() == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("strategy", ["stochastic_greedy", "relaxed", "backward_greedy", "automatic"])
def test_other_strategies_come_close_to_greedy(rng, strategy):
    blocks = pinhole_blocks(rng, 600)
    greedy = maxlogdet.select_blocks(blocks, 80)
    other = maxlogdet.select_blocks(blocks, 80, strategy=strategy, epsilon=0.01, seed=3)
    assert len(set(other.indices)) == 80
    assert other.log_det == pytest.approx(log_det(information(blocks, other.indices)), abs=1e-6)
    assert other.log_det == pytest.approx(greedy.log_det, abs=0.5)
    assert log_det(information(blocks, range(80))) < greedy.log_det - 1  # so half a nat is close on this problem


def test_automatic_reports_its_choice(rng):
    blocks = rng.normal(size=(90, 2, 6))
    assert maxlogdet.select_blocks(blocks, 10, strategy="automatic").strategy == "lazy_greedy"
    assert maxlogdet.select_blocks(blocks, 80, strategy="automatic").strategy == "backward_greedy"


def test_the_seed_determines_stochastic_greedy(rng):
    blocks = rng.normal(size=(500, 2, 6))
    answers = [maxlogdet.select_blocks(blocks, 40, strategy="stochastic_greedy", epsilon=0.5, seed=s).indices.tolist()
               for s in (1, 1, 2, 2**64 - 1)]
    assert answers[0] == answers[1]
    assert answers[0] != answers[2]
    assert answers[2] != answers[3]


def test_blocks_of_different_heights_in_a_list(rng):
    heights = rng.integers(1, 4, size=120)
    blocks = [rng.normal(size=(rows, 6)) for rows in heights]
    blocks[17] = None
    padded = np.zeros((120, 3, 6))
    for i, block in enumerate(blocks):
        if block is not None:
            padded[i, :len(block)] = block
    selection = maxlogdet.select_blocks(blocks, 25)
    assert selection.invalid_candidates == 1
    assert 17 not in selection
    assert check_greedy(padded, selection.indices, allowed=np.arange(120) != 17) > 10


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.float16, np.int32, np.longdouble, ">f8"])
def test_any_real_dtype_and_layout_gives_the_same_answer(rng, dtype):
    blocks = rng.integers(-50, 50, size=(200, 2, 6))
    expected = maxlogdet.select_blocks(blocks.astype(np.float64), 30).indices
    changed = blocks.astype(dtype)
    layouts = [changed, np.asfortranarray(changed), np.repeat(changed, 2, axis=0)[::2], changed[::-1][::-1]]
    for layout in layouts:
        assert np.array_equal(maxlogdet.select_blocks(layout, 30).indices, expected)


def test_unaligned_memory_is_read_correctly(rng):
    blocks = rng.normal(size=(50, 2, 6))
    memory = np.zeros(blocks.nbytes + 1, np.uint8)
    unaligned = memory[1:].view(np.float64).reshape(blocks.shape)
    unaligned[...] = blocks
    assert not unaligned.flags.aligned
    assert np.array_equal(maxlogdet.select_blocks(unaligned, 9).indices, maxlogdet.select_blocks(blocks, 9).indices)


@pytest.mark.parametrize("trial", range(5))
def test_the_prior_is_part_of_the_objective(rng, trial):
    blocks = pinhole_blocks(rng, 120)
    root = rng.normal(size=(6, 6)) * 100
    prior = root @ root.T + np.eye(6)
    selection = maxlogdet.select_blocks(blocks, 15, prior=prior)
    assert check_greedy(blocks, selection.indices, prior) > 5
    assert selection.log_det == pytest.approx(log_det(information(blocks, selection.indices, prior)), abs=1e-6)
    transposed_memory = np.asfortranarray(prior)
    assert np.array_equal(maxlogdet.select_blocks(blocks, 15, prior=transposed_memory).indices, selection.indices)


@pytest.mark.parametrize("trial", range(5))
def test_no_selection_beats_the_certified_bound(rng, trial):
    blocks = rng.normal(size=(12, 2, 6))
    selection = maxlogdet.select_blocks(blocks, 4, certificate=True, certificate_passes=20)
    best = max(log_det(information(blocks, subset)) for subset in itertools.combinations(range(12), 4))
    assert selection.log_det - 1e-9 <= best <= selection.upper_bound + 1e-9
    assert 0 < selection.certified_efficiency <= 1
    looser = maxlogdet.select_blocks(blocks, 4, certificate=True)
    assert looser.upper_bound >= selection.upper_bound


def test_there_is_no_bound_without_certificate(rng):
    selection = maxlogdet.select_blocks(rng.normal(size=(20, 2, 6)), 4)
    assert np.isnan(selection.upper_bound) and np.isnan(selection.certified_efficiency)


def test_exchanges_never_lower_and_sometimes_raise_log_det(rng):
    better = 0
    for _ in range(20):
        blocks = rng.normal(size=(40, 2, 6))
        plain = maxlogdet.select_blocks(blocks, 5)
        swapped = maxlogdet.select_blocks(blocks, 5, exchange_sweeps=10)
        assert swapped.log_det >= plain.log_det
        better += swapped.log_det > plain.log_det + 1e-6
    assert better > 0


def test_required_candidates_come_first_and_excluded_ones_never(rng):
    blocks = rng.normal(size=(100, 2, 6))
    required = np.zeros(100, bool)
    required[[90, 7]] = True
    excluded = rng.random(100) < 0.5
    excluded[required] = False
    selection = maxlogdet.select_blocks(blocks, 20, required=required, excluded=excluded)
    assert set(selection.indices[:2]) == {7, 90}
    assert not excluded[selection.indices].any()
    prior = information(blocks, [7, 90])
    allowed = ~excluded & ~required
    check_greedy(blocks, selection.indices[2:], prior, allowed)


@pytest.mark.parametrize("scale", [1, 1000003])  # small ids, as of cells, and large ids, as of objects
def test_no_group_has_more_than_its_maximum(rng, scale):
    blocks = rng.normal(size=(200, 2, 6))
    groups = rng.integers(0, 10, size=200)
    for most in (1, 3):
        selection = maxlogdet.Selector(200).select(blocks, 100, groups=groups * scale, group_maximum=most)
        assert selection.status == "all_selected"
        assert np.array_equal(np.bincount(groups[selection.indices], minlength=10), np.full(10, most))


def test_each_group_has_its_own_maximum(rng):
    blocks = rng.normal(size=(200, 2, 6))
    groups = rng.integers(0, 5, size=200).astype(np.uint8)
    maxima = [0, 1, 2, 3, 4, 7]  # the last one has no member
    selection = maxlogdet.Selector(200).select(blocks, 100, groups=groups, group_maxima=maxima)
    assert np.bincount(groups[selection.indices], minlength=6).tolist() == [0, 1, 2, 3, 4, 0]


def test_there_may_be_more_maxima_than_candidates(rng):
    blocks = rng.normal(size=(3, 2, 6))
    constraints = dict(groups=[0, 40, 40], group_maxima=np.ones(50, int))
    assert len(maxlogdet.select_blocks(blocks, 3, **constraints)) == 2
    assert len(maxlogdet.Selector(3).select(blocks, 3, **constraints)) == 2
    active = maxlogdet.ActiveSelection(3)
    active.start(blocks, 3, **constraints)
    for _ in active:
        active.accept()
    assert len(active.selection()) == 2


def test_at_a_deadline_the_budget_is_filled(rng):
    blocks = pinhole_blocks(rng, 2000)
    full = maxlogdet.select_blocks(blocks, 500)
    assert full.searched == 500
    cut = maxlogdet.select_blocks(blocks, 500, time_limit=1e-9)
    assert cut.status == "deadline_reached"
    assert len(cut) == len(set(cut)) == 500 and cut.searched == 0
    for limit in (1e-9, 1e-4, 1e-3, 1e9):
        part = maxlogdet.select_blocks(blocks, 500, time_limit=limit)
        assert len(part) == 500
        assert np.array_equal(part.indices[:part.searched], full.indices[:part.searched])
    assert part.status == "ok" and part.searched == 500


def reached(blocks, indices, everything):
    """Efficiency relative to all candidates, and both deviations."""
    matrix = information(blocks, indices)
    covariance = np.linalg.inv(matrix)
    share = np.exp((log_det(matrix) - log_det(information(blocks, everything))) / 6)
    return share, np.sqrt(np.trace(covariance[:3, :3])), np.sqrt(np.trace(covariance[3:, 3:]))


@pytest.mark.parametrize("strategy", ["greedy", "lazy_greedy", "stochastic_greedy", "automatic"])
@pytest.mark.parametrize("which", range(1, 8))
def test_a_selection_stops_as_soon_as_its_target_is_met(rng, strategy, which):
    blocks = pinhole_blocks(rng, 300)
    excluded = rng.random(300) < 0.2
    everything = np.flatnonzero(~excluded)
    plain = dict(strategy=strategy.replace("automatic", "lazy_greedy"), excluded=excluded, seed=3)
    full = maxlogdet.select_blocks(blocks, 150, **plain)
    at = int(rng.integers(10, 140))
    share, *sigmas = reached(blocks, full.indices[:at], everything)
    targets = dict(target_efficiency=share if which & 1 else 0,
                   target_translation_sigma=sigmas[0] if which & 2 else 0,
                   target_rotation_sigma=sigmas[1] if which & 4 else 0)
    selection = maxlogdet.Selector(300).select(blocks, 150, **{**plain, "strategy": strategy}, **targets)
    assert selection.status == "target_reached"
    assert at <= len(selection) <= at + 1  # a prefix meets the target, up to rounding
    assert np.array_equal(selection.indices, full.indices[:len(selection)])
    told = selection.efficiency, selection.translation_sigma, selection.rotation_sigma
    for bit, (value, expected) in enumerate(zip(told, reached(blocks, selection.indices, everything))):
        assert value == pytest.approx(expected, rel=1e-6) if which & 1 << bit else np.isnan(value)


def test_a_target_beyond_the_budget_is_not_reached(rng):
    blocks = pinhole_blocks(rng, 300)
    selection = maxlogdet.select_blocks(blocks, 20, target_efficiency=0.9)
    assert selection.status == "ok" and len(selection) == 20
    assert 0 < selection.efficiency < 0.9
    assert np.isnan(maxlogdet.select_blocks(blocks, 20).efficiency)


def test_nothing_to_select(rng):
    for nothing in ([], np.zeros((0, 2, 6)), maxlogdet.BlockStore()):
        selection = maxlogdet.select_blocks(nothing, 5)
        assert selection.status == "ok"
        assert selection.indices.shape == (0,) and selection.gains.shape == (0,)
    selection = maxlogdet.select_blocks(rng.normal(size=(5, 2, 6)), 0)
    assert (selection.status, len(selection)) == ("ok", 0)


def test_a_budget_above_the_number_selects_all_valid_candidates(rng):
    blocks = rng.normal(size=(30, 2, 6))
    blocks[3, 0, 0] = np.nan
    blocks[4, 1, 5] = np.inf
    blocks[5, 1, 1] = 1e300  # overflows float32
    for budget in (30, 1000, 10**15):
        for selection in (maxlogdet.select_blocks(blocks, budget), maxlogdet.Selector(30).select(blocks, budget)):
            assert (selection.status, selection.error, selection.reason) == ("all_selected", "none", "all_selected")
            assert sorted(selection) == sorted(set(range(30)) - {3, 4, 5})
            assert selection.invalid_candidates == 3


def test_a_selection_is_a_sequence_of_indices(rng):
    blocks = rng.normal(size=(50, 2, 6))
    selection = maxlogdet.select_blocks(blocks, 7)
    assert len(selection) == 7
    assert list(selection) == selection.indices.tolist()
    assert all(type(i) is int for i in selection)
    assert blocks[selection.indices].shape == (7, 2, 6)
    assert selection.indices.dtype == np.intp and selection.gains.dtype == np.float64
    assert "7 selected by lazy_greedy" in repr(selection)


def test_an_answer_outlives_the_next_one_and_the_selector(rng):
    selector = maxlogdet.Selector(100)
    first = selector.select(rng.normal(size=(100, 2, 6)), 10)
    indices, gains = first.indices.copy(), first.gains.copy()
    second = selector.select(rng.normal(size=(100, 2, 6)), 10)
    assert not np.array_equal(second.indices, indices)
    del selector
    assert np.array_equal(first.indices, indices) and np.array_equal(first.gains, gains)
    assert not np.shares_memory(first.indices, second.indices)
