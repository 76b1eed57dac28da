# SPDX-License-Identifier: MIT
"""Progress of what takes long, as the program `maxlogdet` shows it."""

import sys
import time

WIDTH = 30  # characters


class Progress:
    """A line on stderr, if that is a terminal, rewritten in place from two seconds on."""

    def __init__(self, what):
        self.what = what
        self.next = time.monotonic() + 2
        self.is_terminal = sys.stderr.isatty()
        self.is_shown = False

    def update(self, done, everything):
        if not self.is_terminal or time.monotonic() < self.next or everything == 0:
            return
        self.next = time.monotonic() + 0.2
        self.is_shown = True
        bar = "#" * (WIDTH * done // everything)
        percent = 100 * done // everything
        print(f"\r{self.what} [{bar:.<{WIDTH}}] {percent} %\033[K", end="", file=sys.stderr, flush=True)

    def end(self):
        if self.is_shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
