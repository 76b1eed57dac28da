# SPDX-License-Identifier: MIT
"""Makes mutants from the text of the sources: one operator, constant, bound, comparison, condition or line changed."""

import hashlib
import re

from maxlogdet_tools.files import ROOT

KEYWORDS = re.compile(
    r"(return|const|constexpr|auto|using|typedef|namespace|template|static|static_assert|for|while|break|continue|case|"
    r"default|throw|struct|class|enum|friend|virtual|explicit|inline|public|private|else|extern|alignas)\b")
SWAPS = {
    "comparison": {" < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == "},
    "arithmetic": {" + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ", " += ": " -= ", " -= ": " += ",
                   " *= ": " /= "},
    "logic": {" && ": " || ", " || ": " && ", "return true": "return false", "return false": "return true"},
    "extreme": {"std::min(": "std::max(", "std::max(": "std::min(", "min_element": "max_element",
                "max_element": "min_element"},
}
SWAP_PATTERN = {kind: re.compile("|".join(re.escape(s) for s in sorted(swaps, key=len, reverse=True)))
                for kind, swaps in SWAPS.items()}
INTEGER = re.compile(r"(?<![\w.])(\d+)(U|u|)(?![\w.'])")
REAL = re.compile(r"(?<![\w.])(\d+\.\d*|\d+(?:\.\d*)?e[-+]?\d+)(F|f|)(?![\w.])")
NOT = re.compile(r"!(?=[\w(])")
IF = re.compile(r"\bif \(")
DROPPED = re.compile(r"[\w:.\[\]>*&()-]+( (=|\+=|-=|\*=|/=|\|=|&=) |\().*;$|if \(.*\) [^{}]*;$")


def masked(text):
    """The text with comments, strings and preprocessor lines blanked, character for character."""
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#[^\n]*', re.S | re.M)
    return pattern.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def condition_end(line, begin):
    depth = 0
    for i in range(begin, len(line)):
        depth += {"(": 1, ")": -1}.get(line[i], 0)
        if depth == 0:
            return i
    return None


def mutants_of_line(line, code):
    """(kind, mutated line) of each mutant; `code` is the line with everything except code blanked."""
    def replaced(begin, end, text):
        return line[:begin] + text + line[end:]

    if "static_assert" in code or not code.strip():
        return
    for kind, pattern in SWAP_PATTERN.items():
        for m in pattern.finditer(code):
            yield kind, replaced(*m.span(), SWAPS[kind][m.group()])
    for m in INTEGER.finditer(code):
        value = int(m.group(1))
        yield "constant", replaced(*m.span(), f"{value + 1}{m.group(2)}")
        if value > 0:
            yield "constant", replaced(*m.span(), f"{value - 1}{m.group(2)}")
    for m in REAL.finditer(code):
        yield "constant", replaced(*m.span(), f"(10 * {m.group()})")
        yield "constant", replaced(*m.span(), f"({m.group()} / 10)" if float(m.group(1)) else f"1e-3{m.group(2)}")
    for m in NOT.finditer(code):
        yield "logic", replaced(*m.span(), "")
    for m in IF.finditer(code):
        end = condition_end(code, m.end() - 1)
        if end is not None:
            yield "condition", line[: m.end()] + "!(" + line[m.end():end] + ")" + line[end:]
    text = code.strip()
    if DROPPED.match(text) and not KEYWORDS.match(text):
        yield "dropped line", line[: len(line) - len(line.lstrip())] + ";"


def source_files(folders):
    for folder in folders:
        path = ROOT / folder
        if path.is_file():
            yield folder
            continue
        files = [f for f in path.rglob("*") if f.suffix in (".cpp", ".hpp", ".inl")]
        yield from sorted(str(f.relative_to(ROOT)) for f in files)


def mutants_of(file):
    text = (ROOT / file).read_text()
    for number, (line, code) in enumerate(zip(text.split("\n"), masked(text).split("\n"))):
        for kind, mutated in mutants_of_line(line, code):
            yield {"file": file, "line": number + 1, "kind": kind, "before": line.strip(), "after": mutated.strip(),
                   "text": mutated}


def drawn(folders, sample, seed):
    """(mutants, number of all): a random sample of all mutants in these folders; all for a sample of 0."""
    mutants = [mutant for file in source_files(folders) for mutant in mutants_of(file)]

    def order(mutant):
        return hashlib.sha256(f"{seed} {mutant['file']} {mutant['line']} {mutant['after']}".encode()).digest()

    chosen = sorted(mutants, key=order)[:sample or len(mutants)]
    return sorted(chosen, key=lambda m: (m["file"], m["line"])), len(mutants)
