# SPDX-License-Identifier: MIT
"""cameras.bin, images.bin, points3D.bin: little endian, without padding."""

import math
import struct

from maxlogdet_tools.colmap.camera_models import NAMES, parameter_count
from maxlogdet_tools.colmap.model_file import Camera, ModelFile, Point, empty_image

NO_POINT = (1 << 64) - 1
MAX_NAME = 1 << 16  # bytes: a longer one is none


class BinaryFile(ModelFile):
    def __init__(self, file):
        super().__init__(file)
        self.start = 0  # of what was read last

    def place(self):
        return f"{self.file}: byte {self.start}"

    def take(self, size, what):
        """The next bytes."""
        self.start = self.offset
        if size > self.size - self.offset:
            self.fail_at_end(f"{size} bytes from here with {what}, not {self.size - self.offset}")
        content = self.stream.read(size)
        if len(content) != size:
            self.fail_at_end(f"{size} bytes from here with {what}, not {len(content)}")
        self.advance(size)
        return content

    def values(self, form, what):
        return struct.unpack("<" + form, self.take(struct.calcsize("<" + form), what))

    def table(self, row, what):
        """The rows behind their number."""
        (count,) = self.values("Q", f"the number of {what}")
        return struct.iter_unpack("<" + row, self.take(count * struct.calcsize("<" + row), f"{count} {what}"))

    def name(self):
        """The bytes up to the next 0."""
        self.start = self.offset
        name = bytearray()
        while (byte := self.stream.read(1)) != b"\0":
            if not byte:
                self.fail_at_end("a NAME that ends with a byte of 0")
            name += byte
            if len(name) > MAX_NAME:
                self.fail(f"a NAME of at most {MAX_NAME} bytes, and behind it a byte of 0")
        self.advance(len(name) + 1)
        return name.decode(errors="surrogateescape")

    def check_end(self, what):
        self.start = self.offset
        if self.offset != self.size:
            self.fail(f"the end of the file behind the last of its {what}, not {self.size - self.offset} more bytes")


def read_cameras(path):
    """{CAMERA_ID: Camera}"""
    cameras = {}
    with BinaryFile(path) as file:
        (count,) = file.values("Q", "the number of cameras")
        for _ in range(count):
            number, model, width, height = file.values("IiQQ", "CAMERA_ID, MODEL_ID, WIDTH and HEIGHT")
            place = file.place()
            if model not in NAMES:
                file.fail(f"a MODEL_ID of COLMAP, from 0 to {max(NAMES)}, not {model}")
            name = NAMES[model]
            parameters = file.values(f"{parameter_count(name)}d", f"the parameters of {name}")
            camera = Camera(place, name, width, height, parameters)
            file.check_camera(camera)
            file.add_new(cameras, "CAMERA_ID", number, camera)
        file.check_end("cameras")
    return cameras


def read_keypoints(file, image):
    """Those that have a point."""
    rows = file.table("ddQ", "keypoints")
    for i, (u, v, point) in enumerate(rows):
        if not math.isfinite(u) or not math.isfinite(v):
            file.fail(f"finite numbers for X and Y of keypoint {i}, not {u} and {v}")
        if point == NO_POINT:
            continue
        if point >= 1 << 63:
            file.fail(f"a POINT3D_ID from 0 to 2^63 - 1 for keypoint {i}, not {point}")
        image.keypoints.append(i)
        image.points.append(point)
        image.uv.extend((u, v))


def read_images(path):
    """{IMAGE_ID: Image}"""
    images = {}
    with BinaryFile(path) as file:
        (count,) = file.values("Q", "the number of images")
        for _ in range(count):
            number, *pose, camera = file.values("I7dI", "IMAGE_ID, quaternion, translation and CAMERA_ID")
            place = file.place()
            image = empty_image(place, file.name(), camera, pose)
            file.check_image(image)
            file.add_new(images, "IMAGE_ID", number, image)
            read_keypoints(file, image)
        file.check_end("images")
    return images


def read_points(path, wanted):
    """{POINT3D_ID: Point} of those in the set `wanted`."""
    points = {}
    with BinaryFile(path) as file:
        (count,) = file.values("Q", "the number of points")
        for _ in range(count):
            number, *position = file.values("Q3d3xd", "POINT3D_ID, X, Y, Z, R, G, B and ERROR")[:4]
            file.check_finite(position, "XYZ")
            images = {image for image, _ in file.table("II", "observations")}
            if number in wanted:
                file.add_new(points, "POINT3D_ID", number, Point(tuple(position), len(images)))
        file.check_end("points")
    return points
