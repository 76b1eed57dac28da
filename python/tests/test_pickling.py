# SPDX-License-Identifier: MIT
"""Selections, cameras, reports and stores can be pickled and copied."""
import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest

import maxlogdet

SELECTION_NUMBERS = ["status", "error", "reason", "searched", "strategy", "log_det", "upper_bound", "certified_efficiency",
                     "evaluations", "float64_decisions", "invalid_candidates", "threads", "efficiency",
                     "translation_sigma", "rotation_sigma"]
WAYS = [copy.copy, copy.deepcopy] + [
    lambda it, protocol=protocol: pickle.loads(pickle.dumps(it, protocol)) for protocol in range(2, 6)]


def store_of(rng):
    blocks = [None if rng.random() < 0.1 else rng.normal(size=(rng.integers(1, 4), 6)) for _ in range(50)]
    return maxlogdet.BlockStore(blocks)


def assert_same_selection(one, other):
    for name in SELECTION_NUMBERS:
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=0, abs=0, nan_ok=True), name
    assert one.indices.dtype == other.indices.dtype and np.array_equal(one.indices, other.indices)
    assert np.array_equal(one.gains, other.gains, equal_nan=True)
    assert len(one) == len(other) and list(one) == list(other) and repr(one) == repr(other)


@pytest.mark.parametrize("way", WAYS)
def test_selections(rng, way):
    store = store_of(rng)
    for options in (dict(), dict(certificate=True, strategy="automatic"), dict(budget=0), dict(budget=50),
                    dict(target_efficiency=0.3, target_rotation_sigma=0.5)):
        selection = maxlogdet.select_blocks(store, **{"budget": 10, **options})
        assert_same_selection(way(selection), selection)
    refused = maxlogdet.select(maxlogdet.PinholeCamera(400, 400), np.zeros((3, 4)), rng.normal(size=(40, 3)))
    assert (refused.status, len(refused)) == ("error", 40)
    assert_same_selection(way(refused), refused)


@pytest.mark.parametrize("way", WAYS)
def test_cameras_and_reports(rng, way):
    camera = maxlogdet.PinholeCamera(400.5, 401.25, 320, 240, bf=47.5)
    report = maxlogdet.BlockStore().append_blocks(camera, np.eye(4), rng.normal(size=(40, 3)))
    rays = np.array([[1.0, 0, 0], [0, 0, 5]])
    turned = np.array([[0, -1.0, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]])
    singular = maxlogdet.BlockStore().append_blocks(camera, turned, rays + [5, 0, 0], weighting="map_bias_world")
    assert singular.singular_rays == 1
    others = [maxlogdet.Camera(camera), maxlogdet.Camera.radial_tangential(camera, 0.1, 0.02, 1e-3, 2e-3, 0.3),
              maxlogdet.Camera.kannala_brandt(camera, 0.1, 0.02, 0.003, 0.0004),
              maxlogdet.Camera.double_sphere(camera, -0.2, 0.6)]
    for it in others:
        assert np.array_equal(way(it).project([[0.1, 0.2, 1]]), it.project([[0.1, 0.2, 1]]))
        assert repr(way(it)) == repr(it) and way(it).pinhole.bf == it.pinhole.bf
    for it in (camera, report, singular):
        same = way(it)
        assert type(same) is type(it) and same is not it
        assert repr(same) == repr(it)
        for name in vars(type(it)):
            if not name.startswith("_"):
                assert getattr(same, name) == getattr(it, name), name


@pytest.mark.parametrize("way", WAYS)
def test_cameras_of_other_models(rng, way):
    pinhole = maxlogdet.PinholeCamera(400.5, 401.25, 320, 240, bf=47.5)
    points = rng.uniform([-1, -1, 1], [1, 1, 5], size=(20, 3))
    for camera in (maxlogdet.Camera(pinhole), maxlogdet.Camera.double_sphere(pinhole, -0.2, 0.6),
                   maxlogdet.Camera.kannala_brandt(pinhole, 0.01, -0.02, 0.003, -0.0004),
                   maxlogdet.Camera.radial_tangential(pinhole, -0.28, 0.07, 2e-4, 2e-5, 0.01)):
        same = way(camera)
        assert same is not camera and repr(same) == repr(camera)
        assert np.array_equal(same.project(points), camera.project(points))


def test_unknown_camera_models_are_refused():
    for model in (-1, len(maxlogdet.camera_models)):
        with pytest.raises(ValueError, match="another version"):
            maxlogdet.Camera.__new__(maxlogdet.Camera).__setstate__((model, (1.0,) * 10))


@pytest.mark.parametrize("way", WAYS)
def test_stores(rng, way):
    full = store_of(rng)
    for store in (full, maxlogdet.BlockStore(), maxlogdet.BlockStore([None, None])):
        same = way(store)
        assert same is not store and repr(same) == repr(store)
        for name in ("planes", "indices", "valid"):
            assert np.array_equal(getattr(same, name), getattr(store, name)), name
        assert_same_selection(maxlogdet.select_blocks(same, 20), maxlogdet.select_blocks(store, 20))
        same.append(None)
        assert len(same) == len(store) + 1


def test_stores_and_selections_pass_between_processes(rng):
    store = store_of(rng)
    program = ("import pickle, sys, maxlogdet; store, budget = pickle.load(sys.stdin.buffer); "
               "pickle.dump(maxlogdet.select_blocks(store, budget), sys.stdout.buffer)")
    run = subprocess.run([sys.executable, "-B", "-c", program], input=pickle.dumps((store, 10)), check=True,
                         stdout=subprocess.PIPE)
    assert_same_selection(pickle.loads(run.stdout), maxlogdet.select_blocks(store, 10))


def test_objects_with_working_memory_cannot_be_pickled():
    for it in (maxlogdet.Selector(10), maxlogdet.ActiveSelection(10), maxlogdet.GoodFeatures(10)):
        with pytest.raises(TypeError, match="cannot pickle"):
            pickle.dumps(it)


@pytest.mark.parametrize("kind", [maxlogdet.PinholeCamera, maxlogdet.BlockReport, maxlogdet.Selection,
                                  maxlogdet.BlockStore])
def test_pickles_of_another_version_are_refused(kind):
    with pytest.raises(ValueError, match="another version"):
        kind.__new__(kind).__setstate__((1,))
