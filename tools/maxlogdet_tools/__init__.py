# SPDX-License-Identifier: MIT
"""What the project's scripts share: pictures by gnuplot, and pages whose tables are written by programs."""
