# SPDX-License-Identifier: MIT
"""What the files of a model hold, and what their readers share."""

import array
import math
import os
from typing import NamedTuple

from maxlogdet_tools.progress import Progress

MAX_EXTENT = 1 << 20  # px: what the reader of frames takes
UNIT_TOLERANCE = 1e-3  # of the norm of a quaternion: other programs write rounded ones
UPDATE_STEP = 1 << 16  # bytes between looks at the clock


class InputError(Exception):
    """Unusable input: one line that names the place, and what was expected there."""


class Camera(NamedTuple):
    place: str  # in the file, for messages
    model: str  # COLMAP's name of it
    width: int  # px
    height: int
    parameters: tuple  # in COLMAP's order


class Image(NamedTuple):
    place: str
    name: str
    camera: int  # CAMERA_ID
    quaternion: tuple  # of the rotation from world to camera: w, x, y, z
    translation: tuple  # world to camera
    keypoints: array.array  # indices of those with a point
    points: array.array  # POINT3D_ID of each
    uv: array.array  # u and v of each, px


class Point(NamedTuple):
    position: tuple  # X, Y, Z, world frame
    images: int  # number of images that see it


def empty_image(place, name, camera, pose):
    """An image without keypoints. pose: QW, QX, QY, QZ, TX, TY, TZ."""
    keypoints, points, uv = array.array("q"), array.array("q"), array.array("d")
    return Image(place, name, camera, tuple(pose[:4]), tuple(pose[4:]), keypoints, points, uv)


def shown(field):
    """Bytes of a file as messages show them."""
    text = field[:40].decode(errors="replace")
    return "'" + "".join(c if c.isprintable() else "?" for c in text) + ("...'" if len(field) > 40 else "'")


class ModelFile:
    """A file of a model, open for reading. Subclasses name the place of what was read last."""

    def __init__(self, file):
        self.file = file
        try:
            self.stream = open(file, "rb")
            self.size = os.fstat(self.stream.fileno()).st_size
        except OSError as error:
            raise InputError(f"{file}: cannot be opened ({error.strerror}); expected a file of a model") from error
        self.progress = Progress(f"reading {os.path.basename(file)}")
        self.offset = 0  # of what was not read yet
        self.next_update = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.progress.end()
        self.stream.close()

    def place(self):
        raise NotImplementedError

    def fail(self, expected, place=None):
        raise InputError(f"{place or self.place()}: expected {expected}")

    def fail_at_end(self, expected):
        raise InputError(f"{self.place()}: end of file; expected {expected}")

    def advance(self, size):
        self.offset += size
        if self.offset >= self.next_update:
            self.next_update = self.offset + UPDATE_STEP
            self.progress.update(self.offset, self.size)

    def check_finite(self, values, names, place=None):
        for value, name in zip(values, names, strict=True):
            if not math.isfinite(value):
                self.fail(f"a finite number for {name}, not {value}", place)

    def check_camera(self, camera):
        if not 1 <= camera.width <= MAX_EXTENT or not 1 <= camera.height <= MAX_EXTENT:
            self.fail(f"a WIDTH and HEIGHT from 1 to 2^20, not {camera.width} and {camera.height}", camera.place)
        names = [f"parameter {i + 1}" for i in range(len(camera.parameters))]
        self.check_finite(camera.parameters, names, camera.place)

    def check_image(self, image):
        self.check_finite(image.quaternion, ("QW", "QX", "QY", "QZ"), image.place)
        self.check_finite(image.translation, ("TX", "TY", "TZ"), image.place)
        norm = math.hypot(*image.quaternion)
        if abs(norm - 1) > UNIT_TOLERANCE:
            self.fail(f"a quaternion QW, QX, QY, QZ of norm 1, not {norm:.6g}", image.place)
        if not image.name or any(ord(c) < 32 or ord(c) == 127 for c in image.name):
            self.fail("a NAME without control characters, and not an empty one", image.place)

    def add_new(self, table, name, number, value):
        """Adds what has the id `number` to a table of such."""
        if number in table:
            self.fail(f"each {name} once, not {number} twice")
        table[number] = value
