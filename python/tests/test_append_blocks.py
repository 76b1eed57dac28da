# SPDX-License-Identifier: MIT
"""Blocks from points and a pose, compared with the formulas of jacobian.hpp in NumPy."""
import tracemalloc

import numpy as np
import pytest

import maxlogdet

CAMERA = maxlogdet.PinholeCamera(fx=458.0, fy=457.0, cx=367.0, cy=248.0, bf=50.0)


def rotation(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def random_scene(rng, n=60):
    """A pose, points in front of the camera, and these points in the camera's frame."""
    T_cw = np.eye(4)
    T_cw[:3, :3] = rotation(rng)
    T_cw[:3, 3] = rng.normal(size=3)
    p_c = rng.uniform([-3, -2, 1], [3, 2, 20], size=(n, 3))
    points = (p_c - T_cw[:3, 3]) @ T_cw[:3, :3]
    return T_cw, points, p_c


def of_pose(p_c):
    """d p_c / d xi = [I | -[p_c]x], n x 3 x 6."""
    x, y, z = p_c.T
    o, i = np.zeros_like(x), np.ones_like(x)
    return np.stack([np.stack(row, -1) for row in
                     ([i, o, o, o, z, -y], [o, i, o, -z, o, x], [o, o, i, y, -x, o])], 1)


def projection(p_c, depth_cue="none"):
    """d z / d p_c, n x rows x 3."""
    x, y, z = p_c.T
    o = np.zeros_like(x)
    u = [CAMERA.fx / z, o, -CAMERA.fx * x / z**2]
    v = [o, CAMERA.fy / z, -CAMERA.fy * y / z**2]
    rows = {"none": [], "stereo": [[u[0], o, u[2] + CAMERA.bf / z**2]], "depth": [[o, o, np.ones_like(z)]]}[depth_cue]
    return np.stack([np.stack(row, -1) for row in [u, v, *rows]], 1)


def appended(*arguments, **options):
    store = maxlogdet.BlockStore()
    report = store.append_blocks(CAMERA, *arguments, **options)
    assert (report.appended, report.invalid) == (len(store), store.invalid_count)
    return store.planes.transpose(2, 0, 1).astype(np.float64), report


def informations(blocks):
    return np.einsum("nri,nrj->nij", blocks, blocks)


def assert_close(actual, expected):
    scale = np.abs(expected).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(actual / scale, expected / scale, atol=2e-6)  # float32


def test_map_bias_is_the_papers_block(rng):
    T_cw, points, p_c = random_scene(rng)
    blocks, report = appended(T_cw, points, weighting="map_bias")
    assert report.error == "none" and report.appended == 60
    to_plane = np.eye(3) - p_c[:, :, None] * np.array([0, 0, 1]) / p_c[:, 2, None, None]
    assert_close(blocks, (to_plane @ of_pose(p_c))[:, :2])
    with_depth, _ = appended(T_cw, points, weighting="map_bias", depth_cue="depth")
    assert_close(with_depth, of_pose(p_c))


@pytest.mark.parametrize("depth_cue", ["none", "stereo", "depth"])
def test_measurement_is_the_rotated_jacobian_divided_by_sigma(rng, depth_cue):
    T_cw, points, p_c = random_scene(rng)
    sigmas = 1.2 ** rng.integers(0, 8, size=60)
    blocks, _ = appended(T_cw, points, sigmas=sigmas, weighting="measurement", depth_cue=depth_cue, depth_sigma=0.02)
    deviations = np.repeat(sigmas[:, None], blocks.shape[1], axis=1)
    if depth_cue == "depth":
        deviations[:, 2] = 0.02
    expected = projection(p_c, depth_cue) @ of_pose(p_c) / deviations[:, :, None]
    assert_close(informations(blocks), informations(expected))
    if depth_cue == "stereo":
        u, u_right = expected[:, 0].copy(), expected[:, 2].copy()
        expected[:, 0], expected[:, 2] = (u + u_right) / np.sqrt(2), (u_right - u) / np.sqrt(2)
    assert_close(blocks, expected)


@pytest.mark.parametrize("given", ["sigma", "covariances"])
def test_measurement_and_map_whitens_both_noises(rng, given):
    T_cw, points, p_c = random_scene(rng)
    roots = 0.1 * rng.normal(size=(60, 3, 3))
    covariances = roots @ roots.transpose(0, 2, 1)
    options = {"map_sigma": 0.3}
    if given == "sigma":
        covariances = np.broadcast_to(0.3**2 * np.eye(3), (60, 3, 3))
    else:
        options["map_covariances"] = covariances
    blocks, _ = appended(T_cw, points, weighting="measurement_and_map", **options)
    J = projection(p_c)
    H_x, H_p = J @ of_pose(p_c), J @ T_cw[:3, :3]
    sigma = np.eye(2) + H_p @ covariances @ H_p.transpose(0, 2, 1)
    assert_close(informations(blocks), H_x.transpose(0, 2, 1) @ np.linalg.inv(sigma) @ H_x)


def test_weights_multiply_the_information(rng):
    T_cw, points, _ = random_scene(rng)
    weights = rng.uniform(0, 4, size=60)
    plain, _ = appended(T_cw, points)
    weighted, _ = appended(T_cw, points, weights=weights)
    assert_close(informations(weighted), weights[:, None, None] * informations(plain))


def test_matches_without_a_block_keep_their_index(rng):
    T_cw, points, p_c = random_scene(rng)
    usable = np.ones(60, bool)
    usable[[3, 5]] = False
    p_c[10, 2] = -1
    points[10] = (p_c[10] - T_cw[:3, 3]) @ T_cw[:3, :3]
    points[20, 1] = np.nan
    store = maxlogdet.BlockStore([None, None])
    report = store.append_blocks(CAMERA, T_cw, points, usable=usable)
    assert (report.appended, report.invalid, report.behind_camera) == (60, 4, 1)
    assert np.flatnonzero(~store.valid).tolist() == [0, 1, 5, 7, 12, 22]
    assert store.indices.tolist() == np.flatnonzero(store.valid).tolist()
    kept = store.indices - 2
    alone, _ = appended(T_cw, points[kept])
    assert np.array_equal(store.planes.transpose(2, 0, 1), alone)


def test_only_matches_with_a_depth_cue_have_a_third_row(rng):
    T_cw, points, _ = random_scene(rng)
    has_depth_cue = rng.random(60) < 0.5
    blocks, _ = appended(T_cw, points, weighting="measurement", depth_cue="stereo", has_depth_cue=has_depth_cue)
    assert np.array_equal(blocks[:, 2].any(axis=1), has_depth_cue)


def test_singular_rays_are_reported(rng):
    level = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0]])  # looks along the world's y
    points = np.array([[0.0, 5, 0], [1, 5, 1]])
    _, report = appended(level, points, weighting="map_bias_world")
    assert (report.error, report.singular_rays, report.invalid) == ("none", 1, 1)


def test_contiguous_float64_is_read_in_place_and_all_else_is_converted(rng):
    n = 100000
    T_cw, points, _ = random_scene(rng, n)
    sigmas = rng.uniform(1, 2, n)
    usable = np.ones(n, bool)
    store = maxlogdet.BlockStore(capacity=n)

    def append(points):
        store.clear()
        tracemalloc.start()
        store.append_blocks(CAMERA, T_cw, points, sigmas=sigmas, usable=usable, weighting="measurement")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak, np.array(store.planes)

    peak, expected = append(points)
    assert peak < 10000
    peak, planes = append(np.asfortranarray(points))
    assert peak >= points.nbytes  # a conversion would show in the figure above
    assert np.array_equal(planes, expected)
    _, planes = append(points.astype(np.float32).astype(">f4"))
    assert np.abs(planes - expected).max() < 1e-3 * np.abs(expected).max()


def test_float32_points_and_strided_rows_are_read_in_place(rng):
    n = 100000
    T_cw, points, _ = random_scene(rng, n)
    cloud = np.ones((n, 4), np.float32)
    cloud[:, :3] = points
    expected, _ = appended(T_cw, cloud[:, :3].astype(np.float64))
    wide = np.ones((n, 5))
    wide[:, :3] = cloud[:, :3]
    for given in (cloud[:, :3], np.array(cloud[:, :3]), wide[:, :3]):
        store = maxlogdet.BlockStore(capacity=n)
        tracemalloc.start()
        store.append_blocks(CAMERA, T_cw, given)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 10000
        assert np.array_equal(store.planes.transpose(2, 0, 1), expected)
    backwards, _ = appended(T_cw, cloud[::-1, :3])
    assert np.array_equal(backwards, expected[::-1])


def test_covariances_change_the_default_weighting(rng):
    T_cw, points, _ = random_scene(rng)
    covariances = np.broadcast_to(0.01 * np.eye(3), (60, 3, 3))
    plain, _ = appended(T_cw, points)
    measured, _ = appended(T_cw, points, weighting="measurement")
    assert np.array_equal(plain, measured)
    weighed, _ = appended(T_cw, points, map_covariances=covariances)
    both, _ = appended(T_cw, points, map_covariances=covariances, weighting="measurement_and_map")
    assert np.array_equal(weighed, both) and not np.array_equal(weighed, plain)


MODELS = [
    maxlogdet.Camera(CAMERA),
    maxlogdet.Camera.radial_tangential(CAMERA, -0.28, 0.07, 2e-4, 2e-5),
    maxlogdet.Camera.kannala_brandt(CAMERA, 3e-3, 7e-4, -2e-3, 2e-4),
    maxlogdet.Camera.double_sphere(CAMERA, xi=-0.2, alpha=0.59),
]


def test_cameras_are_made_by_the_names_of_models():
    assert maxlogdet.camera_models == tuple(camera.model for camera in MODELS)
    for camera in MODELS:
        assert repr(maxlogdet.Camera.of_model(camera.model, camera.pinhole, camera.parameters)) == repr(camera)
    with pytest.raises(ValueError, match="model: expected one of 'pinhole', .*, got 'fisheye'"):
        maxlogdet.Camera.of_model("fisheye", CAMERA, [])
    with pytest.raises(ValueError, match="parameters: expected 2 of double_sphere, got 3"):
        maxlogdet.Camera.of_model("double_sphere", CAMERA, [0.1, 0.5, 0])


def differences(camera, p_c, h=1e-6):
    steps = h * np.eye(3)
    return np.stack([(camera.project(p_c + s) - camera.project(p_c - s)) / (2 * h) for s in steps], axis=-1)


@pytest.mark.parametrize("camera", MODELS, ids=lambda camera: camera.model)
def test_a_camera_alone_on_a_rig_and_by_its_jacobians_makes_the_same_blocks(rng, camera):
    T_cw, points, p_c = random_scene(rng)
    p_c[:, :2] *= 0.3
    points = (p_c - T_cw[:3, 3]) @ T_cw[:3, :3]
    J = differences(camera, p_c)
    expected = informations(J @ of_pose(p_c))

    def made(camera, *arguments, **options):
        store = maxlogdet.BlockStore()
        assert store.append_blocks(camera, *arguments, **options).invalid == 0
        return informations(store.planes.transpose(2, 0, 1).astype(np.float64))

    def assert_near(actual, expected):
        scale = np.abs(expected).max(axis=(1, 2), keepdims=True)
        np.testing.assert_allclose(actual / scale, expected / scale, atol=1e-5)  # the error of finite differences

    assert_near(made(camera, T_cw, points), expected)
    assert_near(made(CAMERA, T_cw, points, jacobians=J), expected)
    T_cb = np.eye(4)
    T_cb[:3, :3], T_cb[:3, 3] = rotation(rng), rng.normal(size=3)
    ids = rng.integers(0, 2, 60)
    other = (MODELS[1], np.eye(4)[:3])
    on_rig = made([other, (camera, T_cb)], np.linalg.inv(T_cb) @ T_cw, points, camera_ids=np.ones(60, int))
    p_b = (np.c_[p_c, np.ones(60)] @ np.linalg.inv(T_cb).T)[:, :3]
    by_body = informations(J @ T_cb[:3, :3] @ of_pose(p_b))
    assert_near(on_rig, by_body)
    assert_near(made([(camera, T_cb), (camera, T_cb)], np.linalg.inv(T_cb) @ T_cw, points, camera_ids=ids), by_body)


def test_reasons_for_invalid_matches_are_counted():
    points = np.array([[0, 0, 1.0], [0, 0, -1], [0, 0, 1e-9], [0, 0, 2], [0, 0, 3]])
    covariances = np.broadcast_to(1e-4 * np.eye(3), (5, 3, 3)).copy()
    covariances[3, 2, 2] = 1e14
    jacobians = np.ones((5, 2, 3))
    jacobians[0, 0, 0] = np.nan
    usable = np.array([True] * 4 + [False])
    _, report = appended(np.eye(4), points, map_covariances=covariances, jacobians=jacobians, usable=usable)
    assert (report.error, report.invalid) == ("none", 5)
    assert (report.unusable, report.behind_camera, report.too_near) == (1, 1, 1)
    assert (report.invalid_covariances, report.invalid_jacobians) == (1, 1)
    _, report = appended(np.eye(4), points, min_depth=2.5)
    assert (report.behind_camera, report.too_near) == (1, 3)


def test_cameras_project_and_describe_themselves():
    fisheye = maxlogdet.Camera.kannala_brandt(CAMERA, 0, 0, 0, 0)
    assert (fisheye.model, fisheye.parameters, fisheye.pinhole.fx) == ("kannala_brandt", (0, 0, 0, 0), 458.0)
    images = fisheye.project([[0, 0, 1], [1, 0, 0], [0, 0, -1]])
    np.testing.assert_allclose(images, [[367, 248], [367 + 458 * np.pi / 2, 248], [np.nan, np.nan]])
    assert repr(fisheye).startswith("<maxlogdet.Camera: kannala_brandt, PinholeCamera(fx=458.0")


def test_blocks_do_not_depend_on_threads(rng):
    T_cw, points, _ = random_scene(rng, 50000)
    one, _ = appended(T_cw, points, threads=1)
    two, _ = appended(T_cw, points, threads=2)
    assert np.array_equal(one, two)


def test_poses_may_be_3x4_or_4x4(rng):
    T_cw, points, _ = random_scene(rng)
    square, _ = appended(T_cw, points)
    flat, _ = appended(T_cw[:3], points)
    assert np.array_equal(square, flat)


@pytest.mark.parametrize("depth_cue", ["none", "stereo", "depth"])
@pytest.mark.parametrize("kind", ["measurement", "map_sigma", "covariances"])
def test_weights_are_the_inverse_noise_of_the_blocks(depth_cue, kind):
    rng = np.random.default_rng(5)
    T_cw, points, p_c = random_scene(rng)
    options = dict(depth_cue=depth_cue, depth_sigma=0.1, sigmas=rng.uniform(0.5, 3, size=len(points)))
    if kind == "map_sigma":
        options.update(weighting="measurement_and_map", map_sigma=0.2)
    if kind == "covariances":
        root = rng.normal(scale=0.1, size=(len(points), 3, 3))
        options["map_covariances"] = root @ root.transpose(0, 2, 1)
    H = projection(p_c, depth_cue) @ of_pose(p_c)
    omega = maxlogdet.match_information(CAMERA, T_cw, points, **options)
    blocks, _ = appended(T_cw, points, **options)
    assert_close(H.transpose(0, 2, 1) @ omega @ H, informations(blocks))
    W = maxlogdet.match_whitening(CAMERA, T_cw, points, **options)
    assert np.array_equal(W, np.tril(W))
    np.testing.assert_allclose(W.transpose(0, 2, 1) @ W, omega, rtol=1e-10, atol=1e-12 * np.abs(omega).max())


def test_weights_without_a_depth_cue_have_two_rows():
    points = np.array([[0.0, 0, 5], [1, 0, 5], [0, 0, -5]])
    has_depth_cue = np.array([True, False, True])
    omega = maxlogdet.match_information(CAMERA, np.eye(4), points, depth_cue="stereo", has_depth_cue=has_depth_cue)
    np.testing.assert_array_equal(omega[0], np.eye(3))
    np.testing.assert_array_equal(omega[1], np.diag([1.0, 1, 0]))
    assert np.isnan(omega[2]).all()


def test_weights_on_a_rig_equal_those_of_the_camera_at_its_own_pose():
    rng = np.random.default_rng(6)
    T_cw, points, _ = random_scene(rng)
    T_cb = np.eye(4)
    T_cb[:3, :3], T_cb[:3, 3] = rotation(rng), rng.normal(size=3)
    rig = [(CAMERA, np.eye(4)), (CAMERA, T_cb)]
    options = dict(weighting="measurement_and_map", map_sigma=0.2)
    actual = maxlogdet.match_information(rig, np.linalg.inv(T_cb) @ T_cw, points, camera_ids=np.ones(len(points), int),
                                         **options)
    alone = maxlogdet.match_information(CAMERA, T_cw, points, **options)
    np.testing.assert_allclose(actual, alone, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("wrong", [dict(camera=[]), dict(camera_ids=[0, 0, 0]),
                                   dict(camera=[(CAMERA, np.eye(4))], camera_ids=[0, 0, 1])])
def test_weights_of_an_unknown_camera_are_refused(wrong):
    with pytest.raises(maxlogdet.SelectionError, match="invalid_camera_id"):
        maxlogdet.match_information(**{"camera": CAMERA, "T_cw": np.eye(4), "points": np.ones((3, 3)), **wrong})


REFUSED = [
    ("invalid_camera", dict(camera=maxlogdet.PinholeCamera(0, 1))),
    ("invalid_camera", dict(camera=maxlogdet.PinholeCamera(1, 1, np.nan, 0))),
    ("invalid_camera", dict(camera=maxlogdet.PinholeCamera(1, 1), depth_cue="stereo")),
    ("invalid_pose", dict(T_cw=2 * np.eye(4)[:3])),
    ("invalid_pose", dict(T_cw=np.full((3, 4), np.nan))),
    ("invalid_block_options", dict(map_sigma=-1.0)),
    ("invalid_block_options", dict(depth_sigma=0.0)),
    ("invalid_block_options", dict(threads=-1)),
    ("invalid_block_options", dict(min_depth=-1.0)),
    ("invalid_camera", dict(camera=maxlogdet.Camera.kannala_brandt(CAMERA, 0, 0, 0, np.nan))),
    ("invalid_camera", dict(camera=maxlogdet.Camera.kannala_brandt(CAMERA, 0, 0, 0, 0), depth_cue="stereo")),
    ("invalid_camera_id", dict(camera_ids=[0, 0, 0])),
    ("invalid_camera_id", dict(camera=[])),
    ("invalid_camera_id", dict(camera=[(CAMERA, np.eye(4))], camera_ids=[0, 0, 1])),
    ("invalid_camera_id", dict(camera=[(CAMERA, np.eye(4))], camera_ids=[0, 0, 256])),
    ("invalid_pose", dict(camera=[(CAMERA, 2 * np.eye(4)[:3])])),
]


@pytest.mark.parametrize("reason, wrong", REFUSED)
def test_a_refused_call_appends_nothing(reason, wrong):
    store = maxlogdet.BlockStore()
    arguments = {"camera": CAMERA, "T_cw": np.eye(4), "points": np.ones((3, 3)), **wrong}
    with pytest.raises(maxlogdet.SelectionError, match=f"^{reason}: ") as error:
        store.append_blocks(**arguments)
    assert error.value.error == reason
    assert len(store) == 0


@pytest.mark.parametrize("weigh", [maxlogdet.match_information, maxlogdet.match_whitening])
@pytest.mark.parametrize("reason, wrong", [case for case in REFUSED if not {"threads", "min_depth"} & set(case[1])])
def test_arguments_refused_for_blocks_are_refused_for_weights(weigh, reason, wrong):
    with pytest.raises(maxlogdet.SelectionError, match=f"^{reason}: "):
        weigh(**{"camera": CAMERA, "T_cw": np.eye(4), "points": np.ones((3, 3)), **wrong})


@pytest.mark.parametrize("error, text, wrong", [
    (ValueError, r"points: expected shape \(n, 3\), got \(3, 4\)", dict(points=np.ones((3, 4)))),
    (ValueError, r"sigmas: expected shape \(5,\), got \(4,\)", dict(sigmas=np.ones(4))),
    (ValueError, r"map_covariances: expected shape \(5, 3, 3\)", dict(map_covariances=np.ones((5, 9)))),
    (ValueError, r"usable: expected shape \(5,\)", dict(usable=np.ones(6, bool))),
    (TypeError, "has_depth_cue: expected an array of bools", dict(has_depth_cue=np.ones(5, int))),
    (TypeError, "points: expected an array of floats, got complex128", dict(points=np.ones((5, 3), complex))),
    (TypeError, "weights: expected an array of floats, got <U1", dict(weights=list("abcde"))),
    (ValueError, "weighting: expected one of 'map_bias'", dict(weighting="none")),
    (ValueError, r"jacobians: expected shape \(5, 2, 3\)", dict(jacobians=np.ones((5, 6)))),
    (ValueError, r"camera_ids: expected shape \(5,\)", dict(camera_ids=np.zeros(4, int))),
    (ValueError, r"T_cb: expected shape \(3, 4\)", dict(camera=[(CAMERA, np.eye(3))])),
    (TypeError, r"camera: expected a PinholeCamera, a Camera, or a list of \(camera, T_cb\)", dict(camera=[CAMERA])),
    (TypeError, "camera: expected a PinholeCamera", dict(camera=None)),
    (ValueError, "depth_cue: expected one of 'none', 'stereo', 'depth'", dict(depth_cue="rgbd")),
])
def test_messages_name_the_wrong_argument(error, text, wrong):
    store = maxlogdet.BlockStore()
    with pytest.raises(error, match=text):
        store.append_blocks(**{"camera": CAMERA, "T_cw": np.eye(4), "points": np.ones((5, 3)), **wrong})
    assert len(store) == 0


def test_zero_points_are_valid():
    store = maxlogdet.BlockStore()
    assert store.append_blocks(CAMERA, np.eye(4), np.zeros((0, 3)), sigmas=[], usable=[]).appended == 0
    assert repr(CAMERA) == "PinholeCamera(fx=458.0, fy=457.0, cx=367.0, cy=248.0, bf=50.0)"
