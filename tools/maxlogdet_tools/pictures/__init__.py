# SPDX-License-Identifier: MIT
"""A module for each kind of data, which turns the output of a program into gnuplot scripts."""
