# SPDX-License-Identifier: MIT
"""Made-up COLMAP models, written as text and as binary files, and COLMAP's projections."""

import cmath
import math
import struct
from typing import NamedTuple

# MODEL_ID and typical parameters of every camera model that frames have.
CAMERAS = {
    "SIMPLE_PINHOLE": (0, [500.5, 320.5, 239.25]),
    "PINHOLE": (1, [500.5, 480.25, 320.5, 239.25]),
    "SIMPLE_RADIAL": (2, [500.5, 320.5, 239.25, -0.12]),
    "RADIAL": (3, [500.5, 320.5, 239.25, -0.12, 0.031]),
    "OPENCV": (4, [500.5, 480.25, 320.5, 239.25, -0.12, 0.031, 0.0012, -0.0007]),
    "OPENCV_FISHEYE": (5, [300.5, 310.25, 320.5, 239.25, 0.021, -0.0043, 0.0012, -0.0007]),
    "FULL_OPENCV": (6, [500.5, 480.25, 320.5, 239.25, -0.12, 0.031, 0.0012, -0.0007, 0.011, 0.0, 0.0, 0.0]),
    "SIMPLE_RADIAL_FISHEYE": (8, [300.5, 320.5, 239.25, 0.021]),
    "RADIAL_FISHEYE": (9, [300.5, 320.5, 239.25, 0.021, -0.0043]),
    "SIMPLE_FISHEYE": (14, [300.5, 320.5, 239.25]),
    "FISHEYE": (15, [300.5, 310.25, 320.5, 239.25]),
}
OTHER_CAMERAS = {"FOV": (7, [500.5, 480.25, 320.5, 239.25, 0.9]), "THIN_PRISM_FISHEYE": (10, [300.5] * 12)}
MODEL_IDS = {name: number for name, (number, _) in {**CAMERAS, **OTHER_CAMERAS}.items()}


class Camera(NamedTuple):
    model: str
    width: int
    height: int
    parameters: list


class Image(NamedTuple):
    pose: list  # QW, QX, QY, QZ, TX, TY, TZ
    camera: int
    name: str
    keypoints: list  # (u, v, POINT3D_ID or -1)


class Point(NamedTuple):
    position: list
    track: list  # (IMAGE_ID, POINT2D_IDX)


class Model(NamedTuple):
    cameras: dict  # all by id
    images: dict
    points: dict


def write_text(model, folder):
    def words(*values):
        return " ".join(value if isinstance(value, str) else repr(value) for value in values)

    folder.mkdir(exist_ok=True)
    cameras = [words(i, *camera[:3], *camera.parameters) for i, camera in model.cameras.items()]
    images = [line for i, image in model.images.items()
              for line in (words(i, *image.pose, image.camera, image.name), words(*sum(image.keypoints, ())))]
    points = [words(i, *point.position, 9, 8, 7, 0.5, *sum(point.track, ())) for i, point in model.points.items()]
    for name, lines in (("cameras", cameras), ("images", images), ("points3D", points)):
        (folder / f"{name}.txt").write_text("".join(line + "\n" for line in [f"# {name}", *lines]))


def write_binary(model, folder):
    def packed(form, *values):
        return struct.pack("<" + form, *values)

    folder.mkdir(exist_ok=True)
    cameras, images, points = (packed("Q", len(part)) for part in model)
    for i, camera in model.cameras.items():
        cameras += packed("IiQQ", i, MODEL_IDS[camera.model], camera.width, camera.height)
        cameras += packed(f"{len(camera.parameters)}d", *camera.parameters)
    for i, image in model.images.items():
        images += packed("I7dI", i, *image.pose, image.camera) + image.name.encode() + b"\0"
        images += packed("Q", len(image.keypoints))
        images += b"".join(packed("ddq", u, v, point) for u, v, point in image.keypoints)
    for i, point in model.points.items():
        points += packed("Q3d3BdQ", i, *point.position, 9, 8, 7, 0.5, len(point.track))
        points += b"".join(packed("II", *element) for element in point.track)
    for name, content in (("cameras", cameras), ("images", images), ("points3D", points)):
        (folder / f"{name}.bin").write_bytes(content)


def rotated(quaternion, point):
    """q p q*, by Hamilton's product."""
    def product(a, b):
        return [a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]]

    w, x, y, z = quaternion
    return product(product(quaternion, [0, *point]), [w, -x, -y, -z])[1:]


def distorted(model, k, z):
    """COLMAP's distortion of z = X / Z + i Y / Z by the parameters behind the principal point."""
    if "FISHEYE" in model:
        theta = math.atan(abs(z))
        return cmath.rect(theta + sum(k_i * theta ** (2 * i + 3) for i, k_i in enumerate(k)), cmath.phase(z))
    radial, tangential = k[:2], 0j
    if "OPENCV" in model:
        radial, tangential = k[:2] + k[4:5], complex(k[3], k[2])
    rho = abs(z) ** 2
    factor = 1 + sum(k_i * rho ** (i + 1) for i, k_i in enumerate(radial))
    return z * factor + 2 * rho * tangential + z * z * tangential.conjugate()


def projected(camera, point):
    """u, v of a point in the frame of the camera, as COLMAP defines its models."""
    has_one_focal_length = camera.model.startswith("SIMPLE") or "RADIAL" in camera.model
    focal, rest = camera.parameters[:1] * 2, camera.parameters[1:]
    if not has_one_focal_length:
        focal, rest = camera.parameters[:2], camera.parameters[2:]
    image = distorted(camera.model, rest[2:], complex(point[0], point[1]) / point[2])
    return focal[0] * image.real + rest[0], focal[1] * image.imag + rest[1]


def made_up(random, images_of_a_camera=3, point_count=40, camera_names=tuple(CAMERAS)):
    """A model without noise of every camera model; names of images are not in the order of their ids. Each image sees
    most points, and has keypoints without a point."""
    cameras = {10 * i + 3: Camera(name, 640 + i, 480, CAMERAS[name][1]) for i, name in enumerate(camera_names)}
    points = {7 * i + 1: Point([random.uniform(-3, 3), random.uniform(-2, 2), random.uniform(6, 9)], [])
              for i in range(point_count)}
    images = {}
    for i in range(images_of_a_camera * len(cameras)):
        quaternion = [random.choice((-1, 1)), *(random.uniform(-0.1, 0.1) for _ in range(3))]
        norm = math.hypot(*quaternion)
        pose = [q / norm for q in quaternion] + [random.uniform(-0.3, 0.3) for _ in range(3)]
        camera = list(cameras)[i % len(cameras)]
        number, keypoints = 2 * i + 5, []
        for point in random.sample(list(points), k=point_count):
            p_c = [r + t for r, t in zip(rotated(pose[:4], points[point].position), pose[4:], strict=True)]
            is_seen = random.random() < 0.6
            if is_seen:
                points[point].track.append((number, len(keypoints)))
            keypoints.append((*projected(cameras[camera], p_c), point if is_seen else -1))
        images[number] = Image(pose, camera, f"{random.randrange(10**6):06}_{i:03}.jpg", keypoints)
    return Model(cameras, images, points)
