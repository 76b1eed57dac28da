#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws docs/images/matches.png, the picture of README.md: a frame of TUM RGB-D, matched with the points of an earlier
one, and what GoodFeatures makes of the matches. Prints the numbers of its caption. Needs OpenCV's Python module and ours
(docs/python.md).

Usage: PYTHONPATH=tools draw_matches.py FOLDER    tum_fr1_rpy_a of the data; its licence, CC BY 4.0, asks for its name
                                                  beside the picture
"""

import pathlib
import sys

import cv2
import maxlogdet
import numpy as np
from maxlogdet_tools.files import ROOT
from maxlogdet_tools.gnuplot import Colour, Picture, data_block, draw

MAPPED, SHOWN = 60, 63  # numbers of the images


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    pairs, camera = ([line.split() for line in (folder / file).read_text().splitlines() if line[0] != "#"]
                     for file in ("associations.txt", "camera.txt"))  # fmt: skip
    lens, (_, _, units) = (list(map(float, numbers)) for numbers in camera)
    names = pairs[MAPPED][1], pairs[MAPPED][3], pairs[SHOWN][1]
    first, depth, second = (cv2.imread(str(folder / name), cv2.IMREAD_UNCHANGED) for name in names)
    K, distortion = np.array([[lens[0], 0, lens[2]], [0, lens[1], lens[3]], [0, 0, 1]]), np.array(lens[4:])

    orb = cv2.ORB_create(1500)
    mapped, of_mapped = orb.detectAndCompute(first, None)
    seen, of_seen = orb.detectAndCompute(second, None)
    pairs = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(of_mapped, of_seen)
    corners = np.array([mapped[pair.queryIdx].pt for pair in pairs])
    pixels = np.array([seen[pair.trainIdx].pt for pair in pairs])
    sigmas = np.array([1.2 ** seen[pair.trainIdx].octave for pair in pairs])
    u, v = np.round(corners).astype(int).T
    metres = depth[v, u] / units
    rays = cv2.undistortPoints(corners[:, None], K, distortion)[:, 0]
    points = np.column_stack([rays, np.ones(len(rays))]) * metres[:, None]
    points, pixels, sigmas = points[metres > 0], pixels[metres > 0], sigmas[metres > 0]

    good = maxlogdet.GoodFeatures(len(points))
    good.start(maxlogdet.Camera(*lens[:4], model="radial_tangential", parameters=lens[4:]), np.eye(4))
    good.add(points, pixels, sigmas=sigmas)
    selected = set(good.select(100).indices.tolist())
    inliers = good.is_inlier
    print(f"{len(points)} matches, {np.sum(~inliers)} rejected, {len(selected)} selected ({good.reason})")

    height, width = second.shape
    blocks = {"inliers": [i for i in range(len(points)) if inliers[i] and i not in selected],
              "wrong": np.nonzero(~inliers)[0].tolist(), "selected": sorted(selected)}
    grey = [[u, v, round(0.6 * second[v, u])] for v in range(height) for u in range(width)]
    draw(Picture(width, height, (
        data_block("image", grey) + "".join(data_block(name, pixels[rows].tolist()) for name, rows in blocks.items())
        + f"unset border\nunset tics\nunset key\nunset colorbox\nset margins 0,0,0,0\nset xrange [-0.5:{width - 0.5}]\n"
        f"set yrange [{height - 0.5}:-0.5]\nset palette grey\nset cbrange [0:255]\n"
        "plot $image with image, "
        f"$inliers with points pt 7 ps 0.4 lc rgb '{Colour.SKY_BLUE}', "
        "$wrong with points pt 2 ps 0.7 lw 1.5 lc rgb '#ff3020', "
        f"$selected with points pt 7 ps 1.3 lc rgb 'black', $selected with points pt 7 ps 1 lc rgb '{Colour.ORANGE}'\n"
    )), ROOT / "docs/images/matches.png")


if __name__ == "__main__":
    main()
