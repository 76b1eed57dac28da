# SPDX-License-Identifier: MIT
"""The lines of a page that say which command wrote its figures, of which code, where and when: a line a command, between
'<!-- begin run -->' and '<!-- end run -->'.
"""

import datetime
import hashlib
import os
import pathlib
import re
import subprocess
import sys

from maxlogdet_tools.pages import rewrite
from maxlogdet_tools.project import ROOT, cpu_model

LIBRARY = ["include", "kernel", "simd", "threading"]
CODE = r"-G^[[:space:]]*[^[:space:]/]"  # of git: a line that is not only a comment has changed
LINE = re.compile(r"Written by `(?P<command>[^`]+)`: library (?P<library>\S+), ")


def output_of(*command):
    """What a program prints; nothing where it is missing or fails."""
    try:
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def library_state():
    """The last commit that changed code of the library, with a + and a hash of what has changed since, if code has."""
    commit = output_of("git", "log", "-1", "--format=%h", "--abbrev=8", CODE, "--", *LIBRARY) or "unknown"
    changes = output_of("git", "diff", "HEAD", CODE, "--", *LIBRARY)
    return commit + (f"+{hashlib.sha1(changes.encode()).hexdigest()[:6]}" if changes else "")


def widest_isa():
    flags = pathlib.Path("/proc/cpuinfo").read_text()
    return next((isa for isa, flag in (("avx512", "avx512vl"), ("avx2", "avx2"), ("sse2", "sse2")) if flag in flags), "neon")


def run_of(room):
    compiler = output_of(os.environ.get("CXX", "c++"), "-dumpfullversion", "-dumpversion")
    name = "clang" if "clang" in output_of(os.environ.get("CXX", "c++"), "--version") else "gcc"
    return (f"Written by `bench/run {room}`: library {library_state()}, {cpu_model()}, {os.cpu_count()} cores, {widest_isa()}, "
            f"{name} {compiler}, {datetime.date.today()}.")


def lines_of(page):
    text = pathlib.Path(page).read_text().split("<!-- begin run -->\n")
    return text[1].split("<!-- end run -->")[0].splitlines() if len(text) == 2 else []


def stamp(page, room):
    """Says on the page that `bench/run ROOM`, whose options may follow, has just written figures of it."""
    others = [line for line in lines_of(page) if not line.startswith(f"Written by `bench/run {room}`:")]
    rewrite(page, "run", sorted([*others, run_of(room)]))


def main():
    """Prints the lines of all pages, and marks those of another state of the library than this checkout's; --state: prints
    that state alone.
    """
    now = library_state()
    if sys.argv[1:] == ["--state"]:
        print(now)
        return
    for page in sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")]):
        for line in lines_of(page):
            known = LINE.match(line)
            mark = "" if known and known["library"] == now else "   <- another state of the library"
            print(f"{page.relative_to(ROOT)}: {line}{mark}")


if __name__ == "__main__":
    main()
