# SPDX-License-Identifier: MIT
"""Draws gnuplot scripts into .svg and .png files."""

import contextlib
import math
import pathlib
import subprocess
import sys
from typing import NamedTuple

from maxlogdet_tools.files import shown

TERMINALS = {
    ".svg": "svg size {width},{height} dynamic noenhanced font 'sans-serif,14' background 'white'",
    ".png": "pngcairo size {width},{height} noenhanced font 'sans-serif,11' background 'white'",
}

# Grid, tics and key of most pictures.
STYLE = """set encoding utf8
set grid lc rgb '#e0e0e0' lw 0.7
set tics nomirror out
set border 3
set key outside right center reverse Left spacing 1.2
"""


class Colour:  # Okabe and Ito's, which colour-blind people can distinguish
    BLACK = "#000000"
    ORANGE = "#e69f00"
    SKY_BLUE = "#56b4e9"
    GREEN = "#009e73"
    BLUE = "#0072b2"
    VERMILION = "#d55e00"
    PURPLE = "#cc79a7"


class Picture(NamedTuple):
    width: int  # px
    height: int
    script: str  # without terminal and output


def quoted(text):
    """A gnuplot string."""
    return "'" + str(text).replace("'", "''") + "'"


def number(value):
    """All digits of a number for gnuplot, NaN for None; without a point if it is an integer."""
    if value is None or math.isnan(value):
        return "NaN"
    return str(int(value)) if value == int(value) else repr(float(value))


def data_block(name, rows):
    """The data block $NAME; without rows it holds a point that is not drawn."""
    text = lambda cell: cell if isinstance(cell, str) else number(cell)
    lines = [" ".join(map(text, row)) for row in rows]
    return f"${name} << EOD\n" + "".join(line + "\n" for line in lines or ["NaN NaN NaN NaN"]) + "EOD\n"


def draw(picture, file):
    """Draws a picture into a file that ends in .svg or .png. If that fails, an older file is unchanged."""
    file = pathlib.Path(file)
    if file.suffix not in TERMINALS:
        sys.exit(f"{file}: expected a picture that ends in .svg or .png")
    terminal = TERMINALS[file.suffix].format(width=picture.width, height=picture.height)
    try:
        gnuplot = subprocess.run(["gnuplot"], input=f"set terminal {terminal}\n{picture.script}".encode(),
                                 capture_output=True, check=False)
    except FileNotFoundError:
        sys.exit(f"{file}: cannot be drawn; expected gnuplot to be installed (Debian: apt-get install gnuplot-nox)")
    if gnuplot.returncode != 0 or not gnuplot.stdout:
        reasons = [line.strip() for line in gnuplot.stderr.decode(errors="replace").splitlines() if line.strip(" ^")]
        sys.exit(f"{file}: gnuplot could not draw it" + (f": {reasons[-1]}" if reasons else ""))
    write_whole(file, gnuplot.stdout)


def draw_both(picture, stem):
    """Draws STEM.svg and STEM.png, and prints their names."""
    for suffix in TERMINALS:
        draw(picture, f"{stem}{suffix}")
    print(f"drew {shown(stem)}.svg and .png")


def write_whole(file, content):
    """Replaces a file once its new content is complete."""
    unfinished = file.with_name(file.name + ".new")
    try:
        unfinished.write_bytes(content)
        unfinished.replace(file)
    except OSError as error:
        with contextlib.suppress(OSError):
            unfinished.unlink()
        sys.exit(f"{file}: cannot be written ({error.strerror}); expected a folder with room that can be written to")
