# SPDX-License-Identifier: MIT
"""cameras.txt, images.txt, points3D.txt."""

import math

from maxlogdet_tools.colmap.model_file import Camera, ModelFile, Point, empty_image, shown

POSE = ("QW", "QX", "QY", "QZ", "TX", "TY", "TZ")


class TextFile(ModelFile):
    def __init__(self, file):
        super().__init__(file)
        self.line = 0

    def place(self):
        return f"{self.file}:{self.line}"

    def following(self):
        """The next line without surrounding blanks; None at the end."""
        text = self.stream.readline()
        if not text:
            return None
        self.line += 1
        self.advance(len(text))
        return text.strip()

    def next(self):
        """The next line that is neither empty nor a comment; None at the end."""
        while (text := self.following()) is not None:
            if text and not text.startswith(b"#"):
                return text
        return None

    def integer(self, field, name):
        if not field.isdigit() or int(field) >= 1 << 63:
            self.fail(f"an integer from 0 to 2^63 - 1 for {name}, not {shown(field)}")
        return int(field)

    def number(self, field, name):
        try:
            value = float(field)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or b"_" in field:  # Python reads 1_000
            self.fail(f"a finite number for {name}, not {shown(field)}")
        return value


def read_cameras(path):
    """{CAMERA_ID: Camera}"""
    cameras = {}
    with TextFile(path) as file:
        while (text := file.next()) is not None:
            fields = text.split()
            if len(fields) < 5:
                file.fail(f"CAMERA_ID, MODEL, WIDTH, HEIGHT and parameters, not {len(fields)} fields")
            number = file.integer(fields[0], "CAMERA_ID")
            width, height = file.integer(fields[2], "WIDTH"), file.integer(fields[3], "HEIGHT")
            parameters = tuple(file.number(field, f"parameter {i}") for i, field in enumerate(fields[4:], 1))
            camera = Camera(file.place(), fields[1].decode(errors="replace"), width, height, parameters)
            file.check_camera(camera)
            file.add_new(cameras, "CAMERA_ID", number, camera)
    return cameras


def read_keypoints(file, image, text):
    """Those that have a point."""
    fields = text.split()
    if len(fields) % 3:
        file.fail(f"X, Y and POINT3D_ID of each keypoint, not {len(fields)} fields")
    for i in range(0, len(fields), 3):
        u, v = file.number(fields[i], "X"), file.number(fields[i + 1], "Y")
        if fields[i + 2] != b"-1":
            image.keypoints.append(i // 3)
            image.points.append(file.integer(fields[i + 2], "POINT3D_ID"))
            image.uv.extend((u, v))


def read_images(path):
    """{IMAGE_ID: Image}"""
    images = {}
    with TextFile(path) as file:
        while (text := file.next()) is not None:
            fields = text.split(maxsplit=9)  # a name may have blanks
            if len(fields) < 10:
                file.fail(f"IMAGE_ID, {', '.join(POSE)}, CAMERA_ID and NAME, not {len(fields)} fields")
            number, camera = file.integer(fields[0], "IMAGE_ID"), file.integer(fields[8], "CAMERA_ID")
            pose = [file.number(field, name) for field, name in zip(fields[1:8], POSE, strict=True)]
            image = empty_image(file.place(), fields[9].decode(errors="surrogateescape"), camera, pose)
            file.check_image(image)
            file.add_new(images, "IMAGE_ID", number, image)
            keypoints = file.following()  # an empty line if there are none
            if keypoints is None:
                file.fail_at_end("a line with the keypoints of this image")
            read_keypoints(file, image, keypoints)
    return images


def read_points(path, wanted):
    """{POINT3D_ID: Point} of those in the set `wanted`."""
    points = {}
    with TextFile(path) as file:
        while (text := file.next()) is not None:
            fields = text.split()
            if len(fields) < 8 or len(fields) % 2:
                file.fail("POINT3D_ID, X, Y, Z, R, G, B, ERROR, then IMAGE_ID and POINT2D_IDX of each observation, "
                          f"not {len(fields)} fields")
            number = file.integer(fields[0], "POINT3D_ID")
            position = tuple(file.number(field, name) for field, name in zip(fields[1:4], "XYZ", strict=True))
            images = {file.integer(field, "IMAGE_ID") for field in fields[8::2]}
            if number in wanted:
                file.add_new(points, "POINT3D_ID", number, Point(position, len(images)))
    return points
