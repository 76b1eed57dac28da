#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws docs/images/matches.png, the picture of README.md: a frame of TUM RGB-D, matched with the points of an earlier
one, and what GoodFeatures makes of the matches. Prints the numbers of its caption. Needs NumPy and the Python module
(docs/python.md).

Usage: PYTHONPATH=tools draw_matches.py FOLDER    tum_fr1_rpy_a of the data; its licence, CC BY 4.0, asks for its name
                                                  beside the picture
"""

import pathlib
import struct
import sys
import zlib

import maxlogdet
import numpy as np
from maxlogdet_tools.files import ROOT
from maxlogdet_tools.gnuplot import Colour, Picture, data_block, draw

MAPPED, SHOWN = 60, 63  # numbers of the images
HALF = 5  # px, of a patch
REACH = 90  # px, how far a corner may have moved


def read_png(file):
    """A grey image of 8 or 16 bits."""
    data, at, packed = file.read_bytes(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", body[:10])
            assert colour == 0 and bits in (8, 16), f"{file}: expected a grey image"
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    step = bits // 8
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + step * width)
    above, rows = [0] * (step * width), []
    for line in lines.tolist():
        how, row = line[0], line[1:]
        for i, value in enumerate(row):
            a, b, c = (row[i - step] if i >= step else 0), above[i], (above[i - step] if i >= step else 0)
            p = a + b - c
            paeth = min((a, b, c), key=lambda x: abs(p - x)) if how == 4 else 0
            row[i] = (value + (0, a, b, (a + b) // 2, paeth)[how]) & 255
        rows.append(row)
        above = row
    return np.array(rows, np.uint8).view(">u1" if step == 1 else ">u2").astype(float)


def blurred(image):
    for axis in (0, 1):
        image = sum(weight * np.roll(image, shift, axis) for weight, shift in zip((1, 4, 6, 4, 1), range(-2, 3))) / 16
    return image


def corners_of(image, most):
    """[(u, v)] of the strongest corners by Shi and Tomasi, at least 5 px apart."""
    dv, du = np.gradient(blurred(image))
    a, b, c = blurred(du * du), blurred(du * dv), blurred(dv * dv)
    strength = (a + c) / 2 - np.sqrt(((a - c) / 2) ** 2 + b * b)
    strength[:2 * HALF], strength[-2 * HALF:], strength[:, :2 * HALF], strength[:, -2 * HALF:] = 0, 0, 0, 0
    highest = strength.copy()
    for axis in (0, 1):
        highest = np.max([np.roll(highest, shift, axis) for shift in range(-2, 3)], axis=0)
    v, u = np.nonzero((strength == highest) & (strength > 1))
    best = np.argsort(-strength[v, u])[:most]
    return np.stack([u[best], v[best]], axis=1)


def patches_of(image, corners):
    offsets = np.arange(-HALF, HALF + 1)
    patches = image[corners[:, 1, None, None] + offsets[:, None], corners[:, 0, None, None] + offsets]
    patches = patches.reshape(len(corners), -1)
    patches = patches - patches.mean(axis=1, keepdims=True)
    return patches / np.linalg.norm(patches, axis=1, keepdims=True)


def matches_of(first, second, corners):
    """(indices of corners, pixels of the second image): corners whose patches are nearest to each other, both ways."""
    others = corners_of(second, 3000)
    likeness = patches_of(blurred(first), corners) @ patches_of(blurred(second), others).T
    likeness[np.abs(corners[:, None] - others[None]).max(axis=2) > REACH] = -1
    there, back = likeness.argmax(axis=1), likeness.argmax(axis=0)
    found = np.nonzero((back[there] == np.arange(len(corners))) & (likeness.max(axis=1) > 0.7))[0]
    return found, others[there[found]]


def rays_of(pixels, lens):
    """Undistorted, on the plane z = 1."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = lens
    seen = (pixels - [cx, cy]) / [fx, fy]
    ray = seen
    for _ in range(20):
        x, y = ray.T
        rho = x * x + y * y
        tangential = [2 * p1 * x * y + p2 * (rho + 2 * x * x), p1 * (rho + 2 * y * y) + 2 * p2 * x * y]
        ray = (seen - np.stack(tangential, axis=1)) / (1 + rho * (k1 + rho * (k2 + rho * k3)))[:, None]
    return np.column_stack([ray, np.ones(len(ray))])


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    pairs, camera = ([line.split() for line in (folder / file).read_text().splitlines() if line[0] != "#"]
                     for file in ("associations.txt", "camera.txt"))  # fmt: skip
    lens, (_, _, units) = (list(map(float, numbers)) for numbers in camera)
    first, depth, second = (read_png(folder / name) for name in (pairs[MAPPED][1], pairs[MAPPED][3], pairs[SHOWN][1]))

    corners = corners_of(first, 1500)
    metres = depth[corners[:, 1], corners[:, 0]] / units
    corners, metres = corners[metres > 0], metres[metres > 0]
    found, pixels = matches_of(first, second, corners)
    points = rays_of(corners[found], lens) * metres[found, None]

    good = maxlogdet.GoodFeatures(len(points))
    good.start(maxlogdet.Camera(*lens[:4], model="radial_tangential", parameters=lens[4:]), np.eye(4))
    good.add(points, pixels)
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
