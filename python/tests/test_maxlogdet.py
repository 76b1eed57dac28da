# SPDX-License-Identifier: MIT
"""The module: answers against NumPy, arguments that are refused, and the package with its pages."""
import ast
import concurrent.futures
import copy
import os
import pathlib
import pickle
import re

import numpy as np
import pytest

import maxlogdet

SOURCE = pathlib.Path(__file__).parents[2]
LENS = 458.0, 457.0, 367.0, 248.0, 50.0  # fx, fy, cx, cy, bf
CAMERA = maxlogdet.Camera(*LENS)
IDENTITY = np.eye(4)
BLOCKS = np.random.default_rng(7).normal(size=(100, 2, 6))
N = 300


@pytest.fixture
def frame():
    x, y, z = np.random.default_rng(7).uniform([-0.7, -0.5, 2], [0.7, 0.5, 20], size=(N, 3)).T
    return np.stack([x * z, y * z, z], axis=1), np.stack([x, y], axis=1) * LENS[:2] + LENS[2:4]


def started(points, pixels=None, camera=CAMERA, T_cw=IDENTITY, capacity=1000, **more):
    good = maxlogdet.GoodFeatures(capacity)
    good.start(camera, T_cw)
    good.add(points, pixels, **more)
    return good


def log_det(blocks, indices, prior=1e-5 * np.eye(6)):
    chosen = np.asarray(blocks, np.float32).astype(float)[list(indices)]
    return np.linalg.slogdet(prior + np.einsum("nri,nrj->ij", chosen, chosen))[1]


def blocks_of(points):  # at the identity
    (x, y), d, zero = points[:, :2].T / points[:, 2], 1 / points[:, 2], np.zeros(len(points))
    u = np.stack([d, zero, -x * d, -x * y, 1 + x * x, -y], axis=1)
    v = np.stack([zero, d, -y * d, -1 - y * y, x * y, x], axis=1)
    return np.stack([LENS[0] * u, LENS[1] * v], axis=1)


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_blocks_are_selected_greedily(rows):
    blocks, prior = np.tile(BLOCKS, (1, 2, 1))[:, :rows].copy(), np.diag([1.0, 2, 3, 4, 5, 6])
    blocks[5, 0, 3] = np.nan
    selection = maxlogdet.select_blocks(blocks, 12, required=np.arange(100) == 70, prior=prior, certificate=True)
    assert (selection.status, len(set(selection)), selection.indices[0]) == ("ok", 12, 70)
    for k in range(1, 12):
        free = {*range(100)} - {5, *selection.indices[:k]}
        found = {i: log_det(blocks, [*selection.indices[:k], i], prior) for i in free}
        assert found[selection.indices[k]] == pytest.approx(max(found.values()), abs=1e-6)
    assert selection.log_det == pytest.approx(np.log(720) + selection.gains.sum(), abs=1e-9)
    assert selection.upper_bound >= selection.log_det and 0 < selection.certified_efficiency <= 1
    assert len(maxlogdet.select_blocks(blocks, 10**15)) == 99 and len(maxlogdet.select_blocks(np.zeros((0, 2, 6)))) == 0


def test_strategies_and_options():
    groups = np.arange(100) % 10
    best = maxlogdet.select_blocks(BLOCKS, 20).log_det
    for strategy in maxlogdet.strategies:
        selection = maxlogdet.select_blocks(BLOCKS, 20, strategy=strategy, epsilon=0.01, seed=2**64 - 1)
        assert selection.log_det == pytest.approx(best, abs=0.5)
    grouped = maxlogdet.select_blocks(BLOCKS, 100, groups=groups * 1000003, maximum=2)
    assert np.bincount(groups[grouped.indices]).tolist() == [2] * 10 and np.isnan(grouped.efficiency)
    enough = maxlogdet.select_blocks(BLOCKS, 90, target_efficiency=0.5)
    assert enough.status == "target_reached" and enough.efficiency == pytest.approx(0.5, rel=0.2)
    cut = maxlogdet.select_blocks(BLOCKS, 20, time_limit=1e-9)
    assert (cut.status, len(cut), cut.searched) == ("deadline_reached", 20, 0)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.float16, np.int32, np.longdouble, ">f8"])
def test_every_layout_of_an_array_is_read(dtype):
    blocks = (20 * BLOCKS).astype(int).astype(dtype)
    expected = maxlogdet.select_blocks(blocks.astype(float), 30).indices
    unaligned = np.zeros(blocks.nbytes + 1, np.uint8)[1:].view(dtype).reshape(blocks.shape)
    unaligned[...] = blocks
    for layout in (blocks, np.asfortranarray(blocks), np.repeat(blocks, 2, axis=0)[::2], blocks[::-1][::-1], unaligned):
        assert np.array_equal(maxlogdet.select_blocks(layout, 30).indices, expected)


def test_good_features_select_from_points(frame):
    good = started(*frame, sigmas=np.full(N, 2, int))
    selection = good.select(50)
    expected = maxlogdet.select_blocks(blocks_of(frame[0]) / 2, 50)
    assert np.array_equal(selection.indices, expected.indices) and np.allclose(selection.gains, expected.gains)
    share = np.exp((selection.log_det - log_det(blocks_of(frame[0]) / 2, range(N))) / 6)
    assert good.efficiency() == pytest.approx(share) and good.reason == "ok"
    assert not np.array_equal(good.select(50, seed=1, strategy="stochastic_greedy").indices, expected.indices)
    assert np.array_equal(selection.indices, expected.indices)  # still


@pytest.mark.parametrize("error, camera, T_cw, options", [
    ("invalid_pose", CAMERA, 2 * IDENTITY[:3], {}), ("invalid_pose", CAMERA, IDENTITY + np.eye(4, k=-3), {}),
    ("invalid_pose", maxlogdet.Camera(*LENS, T_cb=np.full((3, 4), np.nan)), IDENTITY, {}),
    ("invalid_camera", maxlogdet.Camera(0, 1, 2, 3), IDENTITY, {}), ("invalid_camera", [], IDENTITY, {}),
    ("invalid_prior", CAMERA, IDENTITY, dict(prior=-np.eye(6))),
])
def test_after_an_error_all_usable_matches_are_selected(frame, error, camera, T_cw, options):
    frame[0][3] = np.nan
    selection = started(*frame, camera, T_cw).select(50, **options)
    assert (selection.status, selection.error, selection.reason) == ("error", error, error)
    assert list(selection) == [i for i in range(N) if i != 3] and np.isnan(selection.gains).all()


def test_alignment_rejects_wrong_matches_and_finds_the_pose(frame):
    points, pixels = frame
    pixels += np.random.default_rng(8).normal(size=(N, 2))
    pixels[::7] += 12
    predicted = np.eye(4)
    predicted[:3, 3] = 0.05
    good = started(points, pixels, T_cw=predicted)
    assert np.array_equal(good.pose, predicted[:3]) and good.is_inlier.all() and not good.pose_information.any()
    found = good.align()
    assert found == good.alignment and found["status"] == "aligned" and found["inliers"] == good.is_inlier.sum()
    assert not good.is_inlier[::7].any() and good.is_inlier.sum() > 0.8 * N
    deviations = np.sqrt(np.diag(np.linalg.inv(good.pose_information)))
    assert (abs(good.pose[:, 3]) < 5 * deviations[:3]).all()
    good.align(1e12 * np.eye(6))
    assert np.allclose(good.pose, predicted[:3], atol=1e-4)
    selected = list(good.select(50))  # aligns again, without the prior
    assert good.is_inlier[selected].all()


def test_what_is_suspicious_is_named(frame):
    points, pixels = frame
    right = pixels[:, 0] - LENS[4] / points[:, 2] + 1000
    good = started(points, pixels + 0.5 * np.random.default_rng(1).normal(size=(N, 2)), u_right=right)
    selection = good.select(50)
    assert (selection.status, selection.warning, selection.reason) == ("ok", good.reason, good.reason)
    assert good.reason == good.alignment["status"] == "misfitting_right_columns"
    assert "cx_right" in maxlogdet.warnings[good.reason]
    verged = started(points, pixels, maxlogdet.Camera(*LENS, cx_right=LENS[2] + 1000), u_right=right)
    assert (verged.select(50).warning, verged.reason, len(verged.outliers(IDENTITY))) == ("none", "ok", 0)


def test_outliers_are_those_that_are_far_off(frame):
    points, pixels = frame
    pixels[::7] += 12
    u_right, depth = pixels[:, 0] - LENS[4] / points[:, 2], points[:, 2] + 0.0
    u_right[::2], depth[::2] = -1, np.nan
    u_right[1::14] += 30
    depth[1::14] += 1
    for cue in dict(u_right=u_right), dict(depth=depth):
        good = started(points, pixels, required=np.arange(N) >= 290, **cue)
        good.rejects_outliers = False
        selected = set(good.select(40))
        assert selected > set(range(290, N))
        expected = [i for i in range(N) if i not in selected and (i % 7 == 0 or i % 14 == 1)]
        assert good.outliers(IDENTITY).tolist() == expected and (good.chi2()[expected] > 5.9).all()
        assert np.isnan(good.chi2()[list(selected)]).all()


def test_options_of_blocks_and_matches_beyond_the_capacity(frame):
    covariances = np.tile(0.01 * np.eye(3), (N, 1, 1))
    covariances[:5] = np.nan
    frame[0][5:12, 2] *= -1
    good = started(*frame, covariances=covariances)
    for name, value in dict(map_sigma=0.1, depth_sigma=0.2, spread=1.5, rejects_outliers=False).items():
        setattr(good, name, value)
        assert getattr(good, name) == value
    good.select(50)
    report = good.block_report
    assert (report["error"], report["behind_camera"], report["invalid_covariances"]) == ("none", 7, 5)
    small = started(*frame, capacity=100)
    assert small.size == N and max(small.select(200)) < 100 and small.reason == "capacity_exceeded"


def test_cameras_of_a_body(frame):
    T_cb = np.array([[0.0, 0, -1, 0.1], [0, 1, 0, 0], [1, 0, 0, 0.2], [0, 0, 0, 1]])
    on_body, T_bw = maxlogdet.Camera(*LENS, T_cb=T_cb), np.linalg.inv(T_cb)
    rig = started(*frame, [maxlogdet.Camera(*LENS, T_cb=T_cb[:3]), on_body], T_bw, camera_ids=np.arange(N) % 2)
    for good in started(*frame, on_body, T_bw), rig:
        assert np.array_equal(good.select(50).indices, started(*frame).select(50).indices)
        assert len(good.outliers(T_bw)) == 0


def test_models_of_cameras(frame):
    x, y = frame[0][:, :2].T / frame[0][:, 2]
    rho, (k1, k2, p1, p2, k3) = x * x + y * y, (-0.05, 0.01, 0.002, -0.003, 0.004)
    scale, angle = 1 + k1 * rho + k2 * rho**2 + k3 * rho**3, np.arctan(np.sqrt(rho))
    twisted = x * scale + 2 * p1 * x * y + p2 * (rho + 2 * x * x), y * scale + p1 * (rho + 2 * y * y) + 2 * p2 * x * y
    fisheye = np.stack([x, y]) / np.sqrt(rho) * (angle + k1 * angle**3 + k2 * angle**5 + p1 * angle**7 + p2 * angle**9)
    for model, image, parameters in (("radial_tangential", twisted, (k1, k2, p1, p2, k3)),
                                     ("kannala_brandt", fisheye, [k1, k2, p1, p2])):
        camera = maxlogdet.Camera(*LENS[:4], model=model, parameters=parameters)
        good = started(frame[0], np.transpose(image) * LENS[:2] + LENS[2:4], camera)
        assert len(good.select(50)) == 50 and len(good.outliers(IDENTITY)) == 0 and np.nanmax(good.chi2()) < 1e-15


@pytest.mark.parametrize("name, wrong, expected", [
    ("points", np.ones((N, 2)), "(n, 3)"), ("pixels", np.ones((9, 2)), "(300, 2)"),
    ("covariances", np.ones((N, 9)), "(300, 3, 3)"), ("required", np.ones(9, bool), "(300,)"),
    *((name, np.ones(9), "(300,)") for name in ("sigmas", "u_right", "depth")),
    *((name, np.ones(9, int), "(300,)") for name in ("camera_ids", "point_ids", "keyframes"))])
def test_wrong_arrays_are_refused(frame, name, wrong, expected):
    good, right = started(*frame), np.ones((N, *wrong.shape[1:]), wrong.dtype)
    with pytest.raises(ValueError, match="^" + re.escape(f"{name}: expected shape {expected}, got {wrong.shape}")):
        good.add(**{"points": frame[0], name: wrong})
    masked = np.ma.masked_array(right, mask=np.ones(right.shape, bool))
    for refused in masked, list(masked), right.astype(complex), [None] * N, "text":
        with pytest.raises(TypeError, match=f"^{name}: expected an array of"):
            good.add(**{"points": frame[0], name: refused})
    assert good.size == N


def test_other_wrong_arguments_are_refused(frame):
    good = started(*frame)
    for wrong in BLOCKS[0], np.ones((9, 4, 6)), np.ones((9, 2, 5)), []:
        with pytest.raises(ValueError, match=r"^blocks: expected shape \(n, r, 6\) with r from 1 to 3, got"):
            maxlogdet.select_blocks(wrong)
    for options in dict(groups=np.zeros(9, int)), dict(groups=[]), dict(prior=np.eye(3)), dict(strategy="best"):
        with pytest.raises(ValueError, match=rf"^{[*options][0]}: expected"):
            good.select(**options)
    for call in (lambda: good.outliers(np.eye(3)), lambda: good.record("a\0b"),
                 lambda: maxlogdet.Camera(*LENS, parameters=[1]), lambda: maxlogdet.Camera(*LENS, model="best"),
                 *(lambda id=id: good.add(frame[0], camera_ids=np.full(N, id)) for id in (256, -1, 2**64 - 1))):
        with pytest.raises(ValueError, match="^(T_cw|folder|model|parameters|camera_ids): expected"):
            call()
    for call in (lambda: good.start([1], IDENTITY), lambda: good.start("ab", IDENTITY), lambda: good.select(-1),
                 lambda: maxlogdet.GoodFeatures.__new__(maxlogdet.GoodFeatures).size, lambda: copy.copy(CAMERA),
                 lambda: pickle.dumps(good, 0), lambda: good.record(3), lambda: good.add(frame[0], required=[1] * N)):
        pytest.raises(TypeError, call)
    with pytest.raises(maxlogdet.SelectionError, match="^invalid_prior: the prior") as raised:
        maxlogdet.select_blocks(BLOCKS, prior=-np.eye(6))
    assert isinstance(raised.value, ValueError) and pickle.loads(pickle.dumps(raised.value)).error == "invalid_prior"
    assert len(good.select(50)) == 50


def test_frames_are_recorded(frame, tmp_path):
    good = maxlogdet.GoodFeatures(N)
    assert good.record(tmp_path / "frames") and good.record(os.fsencode(tmp_path / "frames"))
    for _ in range(2):
        good.start(CAMERA, IDENTITY)
        good.add(*frame, point_ids=np.arange(N), keyframes=np.full(N, 7))
        good.select(50)
    assert sorted(path.name for path in tmp_path.glob("*/*")) == ["frame_000000.csv", "frame_000001.csv"]


def test_threads_may_share_an_object(frame):
    good = maxlogdet.GoodFeatures(N)

    def use(_):
        good.start([CAMERA, CAMERA], IDENTITY)
        good.add(*frame)
        return len(good.select(20)), len(good.outliers(IDENTITY))

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert set(pool.map(use, range(400))) <= {(20, 0), (0, 0)}  # none just after another thread's start()


def test_the_stub_matches_the_module():
    stub = ast.parse((pathlib.Path(maxlogdet.__file__).parent / "__init__.pyi").read_text())
    stub.body = [node for node in stub.body if not isinstance(node, (ast.Import, ast.ImportFrom))]
    classes = [node for node in stub.body if isinstance(node, ast.ClassDef) and "Selection" not in node.name]
    for scope, node in (maxlogdet, stub), *((getattr(maxlogdet, node.name), node) for node in classes):
        members = {getattr(member, "name", None) or member.target.id: member for member in node.body}
        names = {"__init__", *(name for name in vars(scope) if name[0] != "_")}
        assert members.keys() == ({*maxlogdet.__all__, "__version__"} if scope is maxlogdet else names)
        for name, member in members.items():
            if isinstance(member, ast.FunctionDef) and not member.decorator_list:
                signature = ast.parse(f"def {getattr(scope, name).__doc__.splitlines()[0]}: ...").body[0]
                for argument in (*ast.walk(signature.args), *ast.walk(member.args)):
                    vars(argument).pop("annotation", None)
                assert ast.dump(signature.args) == ast.dump(member.args), name


def test_the_version_and_the_code_of_the_documentation(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    version = re.search(r"project\(maxlogdet VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
    assert maxlogdet.__version__ == version and maxlogdet.isa() in ("sse2", "avx2", "avx512", "neon")
    blocks = re.findall(r"^```python\n(.*?)^```$", (SOURCE / "docs/python.md").read_text(), re.DOTALL | re.MULTILINE)
    names = {}
    for number, block in enumerate(blocks):
        exec(compile(block, f"docs/python.md, block {number}", "exec"), names)
    assert blocks and len(names["selected"]) == 200
