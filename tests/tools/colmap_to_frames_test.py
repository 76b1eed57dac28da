# SPDX-License-Identifier: MIT
"""tools/colmap_to_frames: frames of models of text and of binary files, and what it refuses."""

import math
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest
import zlib

import colmap_models
from colmap_models import CAMERAS, Camera, Image, Model, Point
from maxlogdet_tools.colmap.model import read_model
from maxlogdet_tools.colmap.model_file import InputError
from maxlogdet_tools.project import ROOT

# Two images, of which the second in order of id is the first in order of name; three points, of which all but 11 have
# an observation in a third image.
SMALL = Model(
    {1: Camera("PINHOLE", 640, 480, [500.0, 400.0, 320.5, 240.5]),
     4: Camera("SIMPLE_RADIAL", 320, 240, [250.0, 160.0, 120.0, -0.5])},
    {2: Image([1.0, 0.0, 0.0, 0.0, 0.25, -0.5, 2.0], 1, "b.jpg",
              [(1.5, 2.5, -1), (300.25, 200.125, 12), (7.0, 8.0, 11)]),
     9: Image([0.5, 0.5, 0.5, 0.5, 0.0, 0.0, 1e-07], 4, "a b.jpg",
              [(10.0, 20.0, 12), (30.0, 40.0, 11), (50.0, 60.0, 10)]),
     3: Image([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1, "c.jpg", [(11.0, 12.0, 12), (13.0, 14.0, 10)])},
    {12: Point([1.0, -2.0, 3.5], [(2, 1), (9, 0), (3, 0)]), 11: Point([4.0, 5.0, 6.0], [(2, 2), (9, 1)]),
     10: Point([0.1, 1e+22, -7.0], [(9, 2), (3, 1), (3, 0), (2, 0)])})
FRAME_OF_A_B = """# COLMAP image: a b.jpg
# camera: radial_tangential,250.0,250.0,160.0,120.0,-0.5,0.0,0.0,0.0,0.0
# image width,height: 320,240
# Tcw_prior (3x4 row-major, world to camera): 0.0,0.0,1.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0,0.0,1e-07
kp,mp_id,X,Y,Z,u,v,inv_sigma2
0,12,1.0,-2.0,3.5,10.0,20.0,1
2,10,0.1,1e+22,-7.0,50.0,60.0,1
"""


class ColmapToFrames(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.model = self.folder / "model"
        self.output = self.folder / "frames"

    def random(self):
        """Random numbers of this test, whose seed a failure prints."""
        self.seed = zlib.crc32(self.id().encode())
        return random.Random(self.seed)

    def run_tool(self, *options, model=None, output=None):
        command = [sys.executable, ROOT / "tools/colmap_to_frames", "--input", model or self.model,
                   "--output", output or self.output, *options]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def converted(self, *options, model=None, output=None):
        """{file name: content} of the frames."""
        done = self.run_tool(*options, model=model, output=output)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return {file.name: file.read_text() for file in sorted((output or self.output).iterdir())}

    def names(self, *options):
        """Of the images in order of their frames."""
        output = self.folder / "-".join(("frames", *map(str, options))).replace("/", "_")
        contents = self.converted(*options, output=output)
        self.assertEqual(list(contents), [f"frame_{i:06}.csv" for i in range(len(contents))])
        return [content.split("\n")[0].removeprefix("# COLMAP image: ") for content in contents.values()]

    def assert_refused(self, message, *options):
        """message: all of it; {m} in it stands for the folder of the model."""
        done = self.run_tool(*options)
        self.assertEqual(done.stderr, message.replace("{m}", str(self.model)) + "\n")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertFalse(self.output.exists())

    def test_writes_what_the_format_asks_for(self):
        colmap_models.write_text(SMALL, self.model)
        contents = self.converted("--max-frames", "1")
        self.assertEqual(contents, {"frame_000000.csv": FRAME_OF_A_B})

    def test_says_what_it_wrote_and_left_out(self):
        colmap_models.write_text(SMALL, self.model)
        said = self.run_tool().stdout
        self.assertEqual(said, f"wrote 3 frames with 5 matches into {self.output}; left out 2 matches with points that "
                               "fewer than 2 other images see\n")

    def test_text_and_binary_give_the_same_frames_bit_for_bit(self):
        model = colmap_models.made_up(self.random())
        colmap_models.write_text(model, self.folder / "text")
        colmap_models.write_binary(model, self.folder / "binary")
        text = self.converted(model=self.folder / "text", output=self.folder / "from_text")
        binary = self.converted(model=self.folder / "binary", output=self.folder / "from_binary")
        self.assertEqual(len(text), len(model.images))
        self.assertEqual(text, binary, f"seed {self.seed}")

    def test_points_project_onto_their_keypoints_in_every_camera_model(self):
        for name in CAMERAS:
            with self.subTest(name):
                model = colmap_models.made_up(self.random(), images_of_a_camera=9, camera_names=[name])
                colmap_models.write_binary(model, self.model)
                contents = self.converted(output=self.folder / name)
                errors = [error for content in contents.values() for error in errors_of(content)]
                self.assertGreater(len(errors), 50)
                self.assertLess(max(errors), 1e-9, f"seed {self.seed}")

    def test_keeps_every_keypoint_with_a_point(self):
        model = colmap_models.made_up(self.random())
        colmap_models.write_binary(model, self.model)
        contents = list(self.converted("--points-seen-elsewhere", "0").values())
        images = sorted(model.images.values(), key=lambda image: image.name)
        for image, content in zip(images, contents, strict=True):
            rows = [line.split(",") for line in content.splitlines()[5:]]
            expected = [(i, point, u, v) for i, (u, v, point) in enumerate(image.keypoints) if point >= 0]
            found = [(int(row[0]), int(row[1]), float(row[5]), float(row[6])) for row in rows]
            self.assertEqual(found, expected, f"seed {self.seed}")
            for row in rows:
                self.assertEqual([float(x) for x in row[2:5]], model.points[int(row[1])].position)

    def test_frames_are_in_order_of_name(self):
        model = colmap_models.made_up(self.random(), images_of_a_camera=1)
        colmap_models.write_binary(model, self.model)
        names = sorted(image.name for image in model.images.values())
        self.assertEqual(self.names(), names)
        self.assertEqual(self.names("--every", "3"), names[::3])
        self.assertEqual(self.names("--every", "3", "--max-frames", "2"), [names[0], names[3]])
        self.assertEqual(self.names("--max-frames", "1000"), names)
        chosen = self.folder / "chosen.txt"
        chosen.write_text(f"# names\n{names[7]}\r\n\n{names[2]}\n{names[4]}\n")
        self.assertEqual(self.names("--images", chosen), [names[2], names[4], names[7]])
        self.assertEqual(self.names("--images", chosen, "--every", "2"), [names[2], names[7]])

    def test_counts_other_images_and_not_observations(self):
        colmap_models.write_text(SMALL, self.model)
        for least, expected in (("0", [11, 12, 10]), ("1", [11, 12, 10]), ("2", [12, 10])):
            contents = self.converted("--points-seen-elsewhere", least, output=self.folder / least)
            ids = {int(line.split(",")[1]) for line in contents["frame_000000.csv"].splitlines()[5:]}
            self.assertEqual(ids, set(expected))
        self.assert_refused("{m}: expected an image with a point that at least 3 other images see "
                            "(--points-seen-elsewhere)", "--points-seen-elsewhere", "3")

    def test_refuses_camera_models_that_frames_lack_by_name(self):
        supported = ", ".join(("SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE, FULL_OPENCV",
                               "SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, SIMPLE_FISHEYE, FISHEYE"))
        for name, (_, parameters) in colmap_models.OTHER_CAMERAS.items():
            cameras = {**SMALL.cameras, 1: Camera(name, 640, 480, parameters)}
            message = f"expected a camera model that frames have ({supported}), not {name}"
            colmap_models.write_text(SMALL._replace(cameras=cameras), self.model)
            self.assert_refused(f"{{m}}/cameras.txt:2: {message}")
            colmap_models.write_binary(SMALL._replace(cameras=cameras), self.model)
            self.assert_refused(f"{{m}}/cameras.bin: byte 8: {message}")
            only_a_b = self.converted("--max-frames", "1", output=self.folder / name)
            self.assertEqual(list(only_a_b.values()), [FRAME_OF_A_B], "its camera is another one")
            for file in self.model.iterdir():
                file.unlink()

    def test_refuses_malformed_lines(self):
        keypoints = "1.5 2.5 -1 300.25 200.125 12 7.0 8.0 11"
        integer, number = "an integer from 0 to 2^63 - 1", "a finite number"
        for name, old, new, message in (
            ("cameras", "PINHOLE 640 480 500.0 400.0 320.5 240.5", "PINHOLE 640",
             "2: expected CAMERA_ID, MODEL, WIDTH, HEIGHT and parameters, not 3 fields"),
            ("cameras", "640 480", "640 4.8", f"2: expected {integer} for HEIGHT, not '4.8'"),
            ("cameras", "640 480", "0 480", "2: expected a WIDTH and HEIGHT from 1 to 2^20, not 0 and 480"),
            ("cameras", "400.0", "4oo", f"2: expected {number} for parameter 2, not '4oo'"),
            ("cameras", " 240.5", "", "2: expected the parameters of PINHOLE (fx, fy, cx, cy), not 3 numbers"),
            ("cameras", "400.0", "-400.0", "2: expected positive focal lengths"),
            ("cameras", "\n4 ", "\n1 ", "3: expected each CAMERA_ID once, not 1 twice"),
            ("images", " 1 b.jpg", "",
             "2: expected IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID and NAME, not 8 fields"),
            ("images", "-0.5", "nan", f"2: expected {number} for TY, not 'nan'"),
            ("images", "2 1.0", "2 1.5", "2: expected a quaternion QW, QX, QY, QZ of norm 1, not 1.5"),
            ("images", " 1 b.jpg", " 7 b.jpg", "2: expected a CAMERA_ID that {m}/cameras.txt has, not 7"),
            ("images", "b.jpg", "b\x07.jpg", "2: expected a NAME without control characters, and not an empty one"),
            ("images", keypoints, keypoints + " 1", "3: expected X, Y and POINT3D_ID of each keypoint, not 10 fields"),
            ("images", "200.125", "1_000", f"3: expected {number} for Y, not '1_000'"),
            ("images", "-1", "-2", f"3: expected {integer} for POINT3D_ID, not '-2'"),
            ("images", "8.0 11", "8.0 13", "2: expected a POINT3D_ID that {m}/points3D.txt has for keypoint 2, not 13"),
            ("images", "\n9 ", "\n2 ", "4: expected each IMAGE_ID once, not 2 twice"),
            ("images", "11.0 12.0 12 13.0 14.0 10\n", "",
             "6: end of file; expected a line with the keypoints of this image"),
            ("points3D", "0.5 2 1", "0.5 2", "2: expected POINT3D_ID, X, Y, Z, R, G, B, ERROR, then IMAGE_ID and "
                                             "POINT2D_IDX of each observation, not 13 fields"),
            ("points3D", "-2.0", "inf", f"2: expected {number} for Y, not 'inf'"),
            ("points3D", "0.5 2", "0.5 " + "x" * 50, f"2: expected {integer} for IMAGE_ID, not '{'x' * 40}...'"),
            ("points3D", "\n11 ", "\n12 ", "3: expected each POINT3D_ID once, not 12 twice"),
        ):
            with self.subTest(message):
                colmap_models.write_text(SMALL, self.model)
                file = self.model / f"{name}.txt"
                file.write_text(file.read_text().replace(old, new, 1))
                self.assert_refused(f"{{m}}/{name}.txt:{message}")

    def test_refuses_every_truncated_binary_file_and_longer_ones(self):
        colmap_models.write_binary(SMALL, self.model)
        for file in self.model.iterdir():
            whole = file.read_bytes()
            for size in range(len(whole)):
                file.write_bytes(whole[:size])
                with self.assertRaisesRegex(InputError, f"^{file}: byte [0-9]+: end of file; expected [^\n]*$"):
                    read_model(self.model, lambda images: images)
            file.write_bytes(whole + b"\0")
            longer = f"^{file}: byte {len(whole)}: expected the end of the file .*, not 1 more bytes$"
            with self.assertRaisesRegex(InputError, longer):
                read_model(self.model, lambda images: images)
            file.write_bytes(whole)

    def test_says_which_files_are_missing(self):
        self.assert_refused("{m}: expected a folder with a COLMAP model")
        self.model.mkdir()
        expected = "{m}: expected cameras, images and points3D, all .bin or all .txt, and found "
        self.assert_refused(expected + "none of them")
        colmap_models.write_text(SMALL, self.model)
        (self.model / "images.txt").rename(self.model / "images.bin")
        self.assert_refused(expected + "cameras.txt, images.bin, points3D.txt")
        (self.model / "images.txt").mkdir()
        self.assert_refused("{m}/images.txt: cannot be opened (Is a directory); expected a file of a model")

    def test_refuses_a_folder_with_frames_and_keeps_them(self):
        colmap_models.write_text(SMALL, self.model)
        before = self.converted("--max-frames", "1")
        done = self.run_tool()
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, f"{self.output}: expected a folder without frame_*.csv, because old frames would "
                                      "mix with new ones\n")
        self.assertEqual({file.name: file.read_text() for file in self.output.iterdir()}, before)
        done = self.run_tool(output=self.model / "cameras.txt")
        self.assertEqual((done.returncode, done.stderr),
                         (2, f"{self.model / 'cameras.txt'}: expected a folder to write frames into\n"))


def errors_of(frame):
    """The distance of each keypoint from its projected point, px, by the equations of camera_model.hpp."""
    lines = frame.splitlines()
    model, *camera = lines[1].removeprefix("# camera: ").split(",")
    fx, fy, cx, cy, *k = map(float, camera)
    T = [float(x) for x in lines[3].split(": ")[1].split(",")]
    for line in lines[5:]:
        point = [float(x) for x in line.split(",")[2:5]] + [1]
        X, Y, Z = (sum(a * b for a, b in zip(T[4 * i:4 * i + 4], point, strict=True)) for i in range(3))
        x, y = X / Z, Y / Z
        if model == "kannala_brandt":
            theta = math.atan2(math.hypot(X, Y), Z)
            d = theta + k[0] * theta**3 + k[1] * theta**5 + k[2] * theta**7 + k[3] * theta**9
            x, y = X * d / math.hypot(X, Y), Y * d / math.hypot(X, Y)
        elif model == "radial_tangential":
            k1, k2, p1, p2, k3 = k
            rho = x * x + y * y
            r = 1 + k1 * rho + k2 * rho**2 + k3 * rho**3
            x, y = (x * r + 2 * p1 * x * y + p2 * (rho + 2 * x * x), y * r + p1 * (rho + 2 * y * y) + 2 * p2 * x * y)
        u, v = map(float, line.split(",")[5:7])
        yield math.hypot(fx * x + cx - u, fy * y + cy - v)


if __name__ == "__main__":
    unittest.main()
