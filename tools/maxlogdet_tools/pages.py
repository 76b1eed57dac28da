# SPDX-License-Identifier: MIT
"""Markdown pages whose tables programs write. The lines between '<!-- begin run -->' and '<!-- end run -->' of a page, one
for each command, say which command wrote its figures, of which code, where and when.
"""

import datetime
import hashlib
import os
import pathlib
import platform
import re
import subprocess
import sys
import textwrap

from maxlogdet_tools.files import ROOT, shown

WIDTH = 120
LIBRARY = ["include", "kernel", "simd", "threading"]
CODE = r"-G^[[:space:]]*[^[:space:]/]"  # of git: a line that is not only a comment has changed
LINE = re.compile(r"Written by `(?P<command>[^`]+)`: library (?P<library>\S+), ")


def table(header, rows):
    """The lines of a Markdown table; cells are texts, those of the first column not empty."""
    return [" | ".join(header), "|".join(["---"] * len(header)), *(" | ".join(row) for row in rows)]


def paragraph(*sentences):
    """The lines of a paragraph."""
    return textwrap.wrap(" ".join(sentences), WIDTH, break_long_words=False, break_on_hyphens=False)


def replace_between(page, begin, end, text):
    """Replaces the text between the only `begin` and the only `end` of a page."""
    page = pathlib.Path(page)
    old = page.read_text()
    if old.count(begin) != 1 or old.count(end) != 1 or old.index(begin) > old.index(end):
        sys.exit(f"{page}: expected '{begin}' once, and after it '{end}' once")
    head, rest = old.split(begin)
    page.write_text(head + begin + text + end + rest.split(end)[1])


def rewrite(page, name, lines):
    """Rewrites the lines between '<!-- begin NAME -->' and '<!-- end NAME -->' of a page, and prints its name."""
    replace_between(page, f"<!-- begin {name} -->", f"<!-- end {name} -->", "\n" + "\n".join(lines) + "\n")
    print(f"rewrote {name} in {shown(page)}")


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


def run_of(room):
    cpu = pathlib.Path("/proc/cpuinfo").read_text()
    # Virtual machines hide the generation from the name.
    model = re.search(r"^cpu family\s*: (\d+)\nmodel\s*: (\d+)\nmodel name\s*: (.*)", cpu, re.MULTILINE)
    isas = (("avx512", "avx512vl"), ("avx2", "avx2"), ("sse2", "sse2"), ("neon", ""))
    compiler = os.environ.get("CXX", "c++")
    name = "clang" if "clang" in output_of(compiler, "--version") else "gcc"
    return (f"Written by `bench/run {room}`: library {library_state()}, "
            f"{f'{model[3]} (family/model {model[1]}/{model[2]})' if model else platform.machine()}, "
            f"{os.cpu_count()} cores, {next(isa for isa, flag in isas if flag in cpu)}, "
            f"{name} {output_of(compiler, '-dumpfullversion', '-dumpversion')}, {datetime.date.today()}.")


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
