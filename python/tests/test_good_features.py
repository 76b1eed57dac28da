# SPDX-License-Identifier: MIT
"""GoodFeatures and select(): always usable answers, outliers, active matching; against a BlockStore and a Selector."""
import numpy as np
import pytest

import maxlogdet

CAMERA = maxlogdet.PinholeCamera(458.0, 457.0, 367.0, 248.0, 50.0)
LENS = np.array([[458.0, 457.0], [367.0, 248.0]])
IDENTITY = np.eye(4)


def frame(rng, n=300):
    z = rng.uniform(2, 20, n)
    points = np.stack([rng.uniform(-0.7, 0.7, n) * z, rng.uniform(-0.5, 0.5, n) * z, z], axis=1)
    return points, points[:, :2] / z[:, None] * LENS[0] + LENS[1]


def started(points, *arguments, T_cw=IDENTITY, capacity=1000, **more):
    good = maxlogdet.GoodFeatures(capacity)
    good.start(CAMERA, T_cw)
    good.add(points, *arguments, **more)
    return good


def test_selects_as_a_selector_does(rng):
    points, pixels = frame(rng)
    sigmas = rng.uniform(0.5, 3, len(points))
    good = started(points, pixels, sigmas)
    selection = good.select(50, certificate=True)
    blocks = maxlogdet.BlockStore()
    blocks.append_blocks(CAMERA, IDENTITY, points, sigmas=sigmas)
    expected = maxlogdet.Selector(1000).select(blocks, 50, certificate=True)
    assert np.array_equal(selection.indices, expected.indices)
    assert np.array_equal(selection.gains, expected.gains)
    assert selection.log_det == expected.log_det and selection.upper_bound == expected.upper_bound
    assert selection.status == selection.reason == good.reason == "ok" and selection.error == "none"
    assert selection.searched == len(selection) == 50
    once = maxlogdet.select(CAMERA, IDENTITY, points, pixels, sigmas, budget=50)
    assert np.array_equal(once.indices, expected.indices)
    assert 0 < good.efficiency() < 1


def test_what_is_not_finite_is_never_selected_and_always_an_outlier(rng):
    points, pixels = frame(rng)
    sigmas = np.ones(len(points))
    points[3, 1] = pixels[7, 0] = sigmas[11] = np.nan
    points[20, 0] = pixels[21, 1] = np.inf
    sigmas[30] = 0
    broken = {3, 7, 11, 20, 21, 30}
    good = started(points, pixels, sigmas)
    for budget in (50, 294, 299, 1000):
        selection = good.select(budget)
        assert len(selection) == min(budget, 294) and not broken & set(selection)
        assert broken <= set(good.outliers(IDENTITY))


@pytest.mark.parametrize("time_limit", [0.0, 1e-9, 1e-6])
@pytest.mark.parametrize("is_behind", [False, True])
def test_a_full_budget_whatever_the_limit_and_the_pose(rng, is_behind, time_limit):
    points, pixels = frame(rng)
    T_cw = np.diag([-1.0, 1, -1, 1]) if is_behind else IDENTITY
    good = started(points, pixels, T_cw=T_cw)
    selection = good.select(50, time_limit=time_limit)
    assert len(selection) == len(set(selection)) == 50
    if time_limit == 0:
        assert selection.status == ("few_candidates" if is_behind else "ok")
    elif not is_behind:
        assert selection.status in ("ok", "deadline_reached")
    assert len(good.select(1000)) == 300 and good.reason == "all_selected"


def test_after_an_error_all_usable_matches_are_selected(rng):
    points, pixels = frame(rng)
    points[5] = np.nan
    excluded = np.zeros(300, bool)
    excluded[8] = True
    usable = [i for i in range(300) if i not in (5, 8)]
    for T_cw, error in [(np.full((3, 4), np.nan), "invalid_pose"), (2 * IDENTITY[:3], "invalid_pose")]:
        try:
            good = started(points, pixels, T_cw=T_cw)
        except maxlogdet.SelectionError:
            pytest.fail("a bad pose is no exception here")
        selection = good.select(50, excluded=excluded)
        assert selection.status == "error" and selection.error == selection.reason == good.reason == error
        assert list(selection) == usable and np.isnan(selection.gains).all() and np.isnan(selection.log_det)
    good = started(points, pixels)
    assert good.select(50, excluded=excluded, target_efficiency=2).error == "invalid_target"
    assert list(good.selection) == usable
    assert len(good.select(50)) == 50


def test_outliers_are_those_that_are_far_off(rng):
    points, pixels = frame(rng)
    pixels[::7] += 12
    u_right = pixels[:, 0] - 50 / points[:, 2]
    u_right[::2] = -1  # ORB-SLAM's: not measured
    u_right[1::7] += 30
    u_right[u_right < -1] = np.nan
    good = started(points, pixels, u_right=u_right)
    selected = set(good.select(60))
    expected = [i for i in range(300) if i not in selected and (i % 7 == 0 or (i % 7 == 1 and u_right[i] >= 0))]
    assert list(good.outliers(IDENTITY)) == expected
    assert np.isnan(good.chi2[sorted(selected)]).all() and (good.chi2[expected] > 5.9).all()


def test_active_matching_goes_on_with_what_is_matched(rng):
    points, pixels = frame(rng)
    tried = []

    def try_to_match(i):
        tried.append(i)
        return None if i % 3 == 0 else pixels[i] + (30 if i % 5 == 0 else 0)

    good = started(points)
    matched = good.match(try_to_match, 80)
    assert len(tried) == len(set(tried)) and list(matched) == [i for i in tried if i % 3 != 0]
    assert len(matched) == 80
    selection = good.select(20)
    assert len(selection) == 20 and set(selection) <= set(matched)
    wrong = [i for i in sorted(matched) if i % 5 == 0 and i not in set(selection)]
    assert list(good.outliers(IDENTITY)) == wrong


def test_an_exception_passes_through_active_matching(rng):
    good = started(frame(rng)[0])

    def fail(i):
        raise KeyError(i)

    with pytest.raises(KeyError):
        good.match(fail, 10)


def test_wrong_shapes_and_types_raise(rng):
    points, pixels = frame(rng)
    good = started(points, pixels)
    with pytest.raises((TypeError, ValueError), match="points"):
        good.add(points[:, :2])
    with pytest.raises((TypeError, ValueError), match="measured"):
        good.add(points, pixels[:10])
    with pytest.raises((TypeError, ValueError), match="budget"):
        good.select(True)
    with pytest.raises((TypeError, ValueError), match="excluded"):
        good.select(10, excluded=np.zeros(3, bool))
