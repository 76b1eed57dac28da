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


def table_rows(results):
    rows = [["folder", "tried", "invalid", "killed", "equivalent", "unnoticed", "mutation score"]]
    folders = sorted({r["file"].split("/")[0] for r in results})
    for folder in folders + ["all"]:
        c = count([r for r in results if folder in ("all", r["file"].split("/")[0])])
        rows.append([folder, *(c[key] for key in ("tried", "none", "killed", "equivalent", "survived")),
                     f"{100 * c['share']:.1f} %"])
    return rows


def write_survivors(survivors):
    write_csv(ROOT / "ci/results/survivors.csv", ["file", "line", "from", "to", "class", "reason"],
              ([r["file"], r["line"], r["before"], r["after"], r["reason"]["class"], r["reason"]["reason"]]
               for r in survivors))


def write_page(results, total):
    """Writes counts and unnoticed mutants to the page; the record has equivalent survivors, too."""
    code = lambda text: f"`{text}`".replace("|", "\\|")
    survivors = [r for r in results if r["outcome"] == "survived"]
    unnoticed = [r for r in survivors if r["reason"]["class"] != "equivalent"]
    rows = table_rows(results)
    rewrite(ROOT / "docs/trust.md", "mutants", [
        f"Drawn from {total} possible mutants:",
        "",
        *table(rows[0], [[str(c) for c in row] for row in rows[1:]]),
        "",
        *table(["unnoticed", "from", "to", "why it survives"],
               [[f"{r['file']}:{r['line']}", code(r["before"]), code(r["after"]), r["reason"]["reason"]]
                for r in unnoticed]),
    ])
    write_survivors(survivors)


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
            parser.error(f"{folder}: expected a folder or file of the sources, as kernel or simd/losses.inl")
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
    for row in table_rows(results):
        print("  ".join(f"{cell:>12}" for cell in row))
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
