# SPDX-License-Identifier: MIT
"""Frames (docs/frame_format.md) of the images of a model."""

import contextlib
import math
import pathlib

from maxlogdet_tools.colmap.camera_models import frame_camera
from maxlogdet_tools.colmap.model_file import InputError
from maxlogdet_tools.progress import Progress

COLUMNS = "kp,mp_id,X,Y,Z,u,v,inv_sigma2"


def joined(values):
    """All digits of numbers, between commas."""
    return ",".join(map(repr, values))


def pose_of(image):
    """3 x 4 row-major, world to camera. The quaternion is Hamilton's."""
    norm = math.hypot(*image.quaternion)
    w, x, y, z = (entry / norm for entry in image.quaternion)
    t = image.translation
    return [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), t[0],
            2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), t[1],
            2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), t[2]]


def matches_of(image, points, min_others):
    """Places in image.points of those that at least min_others other images see. The track has this one, too."""
    return [i for i, number in enumerate(image.points) if points[number].images - 1 >= min_others]


def frame_of(image, camera, points, matches):
    """The text of a frame. In COLMAP the centre of the upper left pixel is at (0.5, 0.5), for keypoints and principal
    points alike, so neither is shifted."""
    model, parameters = frame_camera(camera)
    lines = [
        f"# COLMAP image: {image.name}",
        f"# camera: {model},{joined(parameters)}",
        f"# image width,height: {camera.width},{camera.height}",
        f"# Tcw_prior (3x4 row-major, world to camera): {joined(pose_of(image))}",
        COLUMNS,
    ]
    for i in matches:
        point, uv = points[image.points[i]], image.uv[2 * i:2 * i + 2]
        lines.append(f"{image.keypoints[i]},{image.points[i]},{joined(point.position)},{joined(uv)},1")
    return "\n".join(lines) + "\n"


def check_output(folder):
    """Raises InputError unless frames can be added to a folder without mixing them with older ones."""
    folder = pathlib.Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: expected a folder to write frames into")
    if any(folder.glob("frame_*.csv")):
        raise InputError(f"{folder}: expected a folder without frame_*.csv, because old frames would mix with new ones")


def write_frames(folder, texts, count):
    """Writes `count` texts as frame_000000.csv and so on into a folder, which is made if there is none. If that fails,
    nothing of it is left."""
    folder = pathlib.Path(folder)
    check_output(folder)
    made = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    written = []
    progress = Progress("writing frames")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for i, text in enumerate(texts):
            written.append(folder / f"frame_{i:06}.csv")
            written[-1].write_bytes(text.encode(errors="surrogateescape"))
            progress.update(len(written), count)
    except BaseException as error:
        with contextlib.suppress(OSError):
            for file in written:
                file.unlink(missing_ok=True)
            for parent in made:
                parent.rmdir()
        if isinstance(error, OSError):
            raise InputError(f"{error.filename or folder}: cannot be written ({error.strerror}); "
                             "expected a folder with room that can be written to") from error
        raise
    finally:
        progress.end()
