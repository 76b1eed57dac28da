# SPDX-License-Identifier: MIT
"""A module a kind of data: what a program wrote in, gnuplot scripts out."""
