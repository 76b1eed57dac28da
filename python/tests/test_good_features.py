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


def test_one_call_also_selects_what_is_behind_the_camera(rng):
    points, pixels = frame(rng, 800)
    selection = maxlogdet.select(CAMERA, np.diag([-1.0, 1, -1, 1]), points, pixels, budget=800)
    assert sorted(selection) == list(range(800)) and np.isnan(selection.gains).all()
    with pytest.raises(TypeError, match="unexpected keyword argument 'spread'"):
        maxlogdet.select(CAMERA, IDENTITY, points, spread=1.5)
    with pytest.raises(TypeError):
        maxlogdet.select(np.ones((5, 2, 6)), 3)  # blocks: select_blocks


@pytest.mark.parametrize("given", ["transposed", "rig", "camera", "options"])
def test_what_is_wrong_with_values_is_told_by_the_selection(rng, given):
    points, pixels = frame(rng)
    transposed = np.eye(4)
    transposed[3, 0] = 0.5
    camera, T_cw, error = {
        "transposed": (CAMERA, transposed, "invalid_pose"),
        "rig": ([(CAMERA, transposed)], IDENTITY, "invalid_pose"),
        "camera": (maxlogdet.PinholeCamera(0, 1), IDENTITY, "invalid_camera"),
        "options": (CAMERA, IDENTITY, "invalid_prior"),
    }[given]
    prior = np.zeros((6, 6)) if given == "options" else None
    selection = maxlogdet.select(camera, T_cw, points, pixels, budget=50, prior=prior)
    assert (selection.status, selection.error, len(selection)) == ("error", error, 300)
    assert error in maxlogdet.errors


def test_too_few_matches_are_all_selected(rng):
    points, pixels = frame(rng, 3)
    assert maxlogdet.select(CAMERA, IDENTITY, points, pixels).reason == "all_selected"
    empty = maxlogdet.select(CAMERA, IDENTITY, np.zeros((0, 3)))
    assert (len(empty), empty.error) == (0, "none")
    assert maxlogdet.GoodFeatures(10).select().error == "invalid_camera"  # before the first start()


def test_matches_beyond_the_capacity_are_counted_but_not_selected(rng):
    points, pixels = frame(rng)
    good = started(points, pixels, capacity=100)
    assert (len(good), good.capacity) == (300, 100)
    assert max(good.select(200)) < 100 and good.reason == "capacity_exceeded"
    assert np.isnan(good.chi2[100:]).all() and good.chi2.shape == (300,)


def test_options_change_blocks_and_outliers(rng):
    points, pixels = frame(rng)
    covariances = np.broadcast_to(0.01 * np.eye(3), (300, 3, 3))
    good = started(points, pixels, covariances=covariances)
    weighed = good.select(50)
    expected = maxlogdet.BlockStore()
    expected.append_blocks(CAMERA, IDENTITY, points, map_covariances=covariances)
    assert np.array_equal(good.blocks().planes, expected.planes)
    assert np.allclose(good.information(), maxlogdet.match_information(CAMERA, IDENTITY, points,
                                                                       map_covariances=covariances))
    W = good.whitening()
    assert np.allclose(W.transpose(0, 2, 1) @ W, good.information())
    turned = np.eye(4)
    turned[0, 3] = 0.1
    plain = len(good.outliers(turned))
    good.is_weighted = True
    assert len(good.outliers(turned)) < plain  # the points are uncertain
    assert np.array_equal(good.selection.indices, weighed.indices)
    good.min_depth = 10.0
    good.select(50)
    assert good.block_report.too_near == (points[:, 2] < 10).sum()
    good.spread = np.nan
    assert good.select(50).error == "invalid_groups"
    for name, wrong in (("weighting", "best"), ("spread", "1"), ("is_weighted", 1), ("map_sigma", None)):
        with pytest.raises((TypeError, ValueError), match=f"^{name}: expected"):
            setattr(good, name, wrong)


def test_a_rig_outlives_the_call_that_starts_a_frame(rng):
    points, pixels = frame(rng)
    ids = rng.integers(0, 2, 300)
    good = maxlogdet.GoodFeatures(300)
    good.start([(CAMERA, np.eye(4)), (CAMERA, np.eye(4))], IDENTITY)
    good.add(points, pixels, camera_ids=ids)
    assert good.select(50).indices.tolist() == maxlogdet.select(CAMERA, IDENTITY, points, pixels,
                                                                budget=50).indices.tolist()
    assert len(good.outliers(IDENTITY)) == 0
    with pytest.raises(ValueError, match=r"camera_ids: expected integers in \[0, 256\)"):
        good.add(points, camera_ids=np.full(300, 256))
    assert len(good) == 300


def test_required_matches_and_depths(rng):
    points, pixels = frame(rng)
    depth = points[:, 2].copy()
    depth[::2] = np.nan
    depth[1::4] += 10
    required = np.arange(300) >= 290
    good = started(points, pixels, depth=depth, required=required)
    selection = good.select(20)
    assert set(selection.indices[:10]) == set(range(290, 300))
    off = [i for i in range(1, 300, 4) if i not in set(selection)]
    assert good.outliers(IDENTITY).tolist() == off
    information = good.information()
    assert information.shape == (300, 3, 3) and information[1, 2, 2] > 0 and not information[0, 2].any()


def test_a_matcher_may_say_what_it_measures_but_not_use_the_object(rng):
    points, pixels = frame(rng)
    good = started(points)

    def measure(i):
        with pytest.raises(RuntimeError, match="selecting or matching"):
            good.add(points)
        return {"measured": pixels[i] + 3, "sigma": 10} if i % 2 else np.bool_(True)

    matched = good.match(measure, 60)
    assert len(matched) == 60
    good.select(10)
    assert len(good.outliers(IDENTITY)) == 0  # 3 px are little at a sigma of 10
    for wrong in ({"u": 1}, [1, 2, 3], "no", {"sigma": None}):
        with pytest.raises((TypeError, ValueError)):
            started(points).match(lambda i, wrong=wrong: wrong, 5)
    with pytest.raises(TypeError, match="try_to_match: expected a function"):
        good.match(100)
    assert len(good.select(10)) == 10  # usable again


def test_frames_are_recorded(rng, tmp_path):
    points, pixels = frame(rng)
    good = maxlogdet.GoodFeatures(300)
    assert good.record(tmp_path / "frames")
    for _ in range(2):
        good.start(CAMERA, IDENTITY)
        good.add(points, pixels, point_ids=np.arange(300), keyframes=np.full(300, 7))
        good.select(50)
    assert len(list((tmp_path / "frames").glob("frame_*.csv"))) == 2
    assert not maxlogdet.GoodFeatures(300).record(tmp_path / "frames")  # in use by that recording
    with pytest.raises(TypeError):
        good.record(3)
