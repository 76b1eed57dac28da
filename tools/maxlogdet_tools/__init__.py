# SPDX-License-Identifier: MIT
"""Shared by the project's scripts: pictures by gnuplot, and Markdown pages with generated tables."""
