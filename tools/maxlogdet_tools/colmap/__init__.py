# SPDX-License-Identifier: MIT
"""Reads COLMAP's models (https://colmap.github.io/format.html), and writes their images as frames."""
