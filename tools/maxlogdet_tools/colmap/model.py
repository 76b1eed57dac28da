# SPDX-License-Identifier: MIT
"""A folder with a model, of text or binary files."""

import pathlib
from typing import NamedTuple

from maxlogdet_tools.colmap import binary, text
from maxlogdet_tools.colmap.model_file import InputError

FILES = ("cameras", "images", "points3D")


class Model(NamedTuple):
    cameras: dict  # {CAMERA_ID: Camera}
    images: list  # those asked for, in their order
    points: dict  # {POINT3D_ID: Point} of those images


def ending_of(folder):
    """.bin, which COLMAP prefers, or .txt: what the folder has all files of."""
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder with a COLMAP model")
    for ending in (".bin", ".txt"):
        if all((folder / (name + ending)).exists() for name in FILES):
            return ending
    found = [file for name in FILES for ending in (".bin", ".txt") if (folder / (file := name + ending)).exists()]
    raise InputError(f"{folder}: expected cameras, images and points3D, all .bin or all .txt, "
                     f"and found {', '.join(found) or 'none of them'}")


def read_model(folder, chosen_of):
    """Reads the images that chosen_of selects from a list of all, which is in order of name, and what they need."""
    folder = pathlib.Path(folder)
    ending = ending_of(folder)
    reader = binary if ending == ".bin" else text
    cameras_file, images_file, points_file = (folder / (name + ending) for name in FILES)
    cameras = reader.read_cameras(cameras_file)
    images = reader.read_images(images_file)
    chosen = chosen_of([image for _, image in sorted(images.items(), key=lambda item: (item[1].name, item[0]))])
    for image in chosen:
        if image.camera not in cameras:
            raise InputError(f"{image.place}: expected a CAMERA_ID that {cameras_file} has, not {image.camera}")
    points = reader.read_points(points_file, {point for image in chosen for point in image.points})
    for image in chosen:
        for keypoint, point in zip(image.keypoints, image.points, strict=True):
            if point not in points:
                raise InputError(f"{image.place}: expected a POINT3D_ID that {points_file} has for keypoint "
                                 f"{keypoint}, not {point}")
    return Model(cameras, chosen, points)
