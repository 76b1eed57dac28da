# SPDX-License-Identifier: MIT
"""Mutation testing: changes one operator, constant, bound, comparison, condition or line of the library at a time, and
reports which of these mutants no test notices.

Mutants are made from the text of the sources; --seed draws a sample from each file in proportion to its mutants. A
mutant that does not compile, or compiles to the same objects, is invalid. A mutant is killed when a test fails or
hangs. build/mutate/results.jsonl keeps the results, so that an interrupted run continues; delete it once tests have
changed.

ci/mutants.json gives the reasons of survivors: `equivalent` ones give the same answers for every input (they only cost
or save time); `unnoticed` ones do not, and count against the tests.
"""

import argparse
import collections
import datetime
import json
import os
import sys

from maxlogdet_tools.files import write_csv
from maxlogdet_tools.pages import rewrite, table
from maxlogdet_tools.project import ROOT
from mutant_worker import read_results, try_all
from mutants import drawn, key

REASONS = ROOT / "ci/mutants.json"


def read_reasons():
    return {key(r): r for r in json.loads(REASONS.read_text())} if REASONS.exists() else {}


def judge(mutants):
    """The results of these mutants, with the reasons of survivors."""
    wanted = {(key(m), m["line"]) for m in mutants}
    reasons = read_reasons()
    results = [r for r in read_results() if (key(r), r["line"]) in wanted]
    for result in results:
        if result["outcome"] == "survived":
            result["reason"] = reasons.get(key(result), {"class": "unnoticed", "reason": ""})
    return results


def count(results):
    outcomes = collections.Counter(r["outcome"] for r in results)
    equivalent = sum(r["outcome"] == "survived" and r["reason"]["class"] == "equivalent" for r in results)
    killed, survived = outcomes["killed"], outcomes["survived"] - equivalent
    share = killed / (killed + survived) if killed + survived else 1
    return {"tried": len(results), "killed": killed, "survived": survived, "equivalent": equivalent,
            "none": outcomes["does not compile"] + outcomes["same code"], "share": share}


def drawn_line(results, total):
    """How many mutants were drawn, and how many of them are valid."""
    c = count(results)
    return f"{c['tried']} of {total} possible mutants were drawn; {c['none']} of them proved invalid."


def table_rows(results):
    """The header, and a row a folder, of the valid mutants."""
    rows = [["folder", "valid (count)", "killed (count)", "equivalent (count)", "unnoticed (count)", "score (%)"]]
    folders = sorted({r["file"].split("/")[0] for r in results})
    for folder in folders + ["all"]:
        c = count([r for r in results if folder in ("all", r["file"].split("/")[0])])
        rows.append([folder if folder == "all" else f"`{folder}/`", str(c["tried"] - c["none"]),
                     *(str(c[key]) for key in ("killed", "equivalent", "survived")), f"{100 * c['share']:.1f}"])
    return rows


def write_survivors(survivors):
    write_csv(ROOT / "ci/results/survivors.csv", ["file", "line", "from", "to", "class", "reason"],
              ([r["file"], r["line"], r["before"], r["after"], r["reason"]["class"], r["reason"]["reason"]]
               for r in survivors))


def write_page(results, total):
    """Writes the counts to the page, and every survivor to the record."""
    header, *rows = table_rows(results)
    rewrite(ROOT / "docs/trust.md", "mutants", [
        f"Run by `ci/mutate --page` on {datetime.date.today()}. {drawn_line(results, total)}",
        "",
        *table(header, rows),
    ])
    write_survivors([r for r in results if r["outcome"] == "survived"])


def arguments_of():
    parser = argparse.ArgumentParser(prog="ci/mutate", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", default=["include", "kernel", "simd", "threading"], help="what to mutate")
    parser.add_argument("--sample", type=int, default=400, help="number of mutants, 0: all (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the sample (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutants at once (default: one per processor)")
    parser.add_argument("--min-score", type=float, default=90, help="per cent to be killed (default: %(default)s)")
    parser.add_argument("--list", action="store_true", help="print the mutants and stop")
    parser.add_argument("--page", action="store_true", help="write docs/trust.md and ci/results from the results")
    arguments = parser.parse_args()
    for folder in arguments.folders:
        if not (ROOT / folder).exists():
            parser.error(f"{folder}: expected a folder or file of the sources, as kernel or simd/gains.inl")
    return arguments


def print_mutant(mutant, title, reason=""):
    print(f"{title}{mutant['file']}:{mutant['line']} {mutant['kind']}\n  - {mutant['before']}\n  + {mutant['after']}"
          + (f"\n  {reason}" if reason else ""))


def main():
    arguments = arguments_of()
    mutants, total = drawn(arguments.folders, arguments.sample, arguments.seed)
    if arguments.list:
        for mutant in mutants:
            print_mutant(mutant, "")
        return
    try_all(mutants, arguments.jobs)
    results = judge(mutants)
    if len(results) < len(mutants):
        sys.exit(f"error: {len(mutants) - len(results)} of {len(mutants)} mutants were not tried; the reason is above")
    print(drawn_line(results, total))
    for row in table_rows(results):
        print("  ".join(f"{cell:>18}" for cell in row))
    for r in results:
        if r["outcome"] == "survived" and r["reason"]["class"] != "equivalent":
            print_mutant(r, "unnoticed: ", r["reason"]["reason"])
    if arguments.page:
        write_page(results, total)
    share = 100 * count(results)["share"]
    print(f"{share:.1f} % of the mutants that matter are killed")
    if share < arguments.min_score:
        sys.exit(1)


main()
