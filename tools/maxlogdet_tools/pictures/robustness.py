# SPDX-License-Identifier: MIT
"""`simulate robustness`: RMS error as a multiple of that of all matches over the budget, a panel for each disturbance; a
picture for translation and one for rotation."""

import math

from maxlogdet_tools.gnuplot import STYLE, Picture, data_block, number
from maxlogdet_tools.selector_styles import line_style

ERRORS = {"translation": "rms_translation_m", "rotation": "rms_rotation_deg"}
MAX_COLUMNS = 4


def curves_of(rows, disturbances, selectors, budgets, column):
    """{(disturbance, selector): [(budget, ratio)]}"""
    found = {(row["disturbance"], row["selector"], row["budget"]): row[column] for row in rows}
    of_all = {row["disturbance"]: row[column] for row in rows if row["selector"] == "all"}
    ratio = lambda error, reference: math.nan if None in (error, reference) or reference == 0 else error / reference
    return {(disturbance, selector): [(budget, ratio(found[disturbance, selector, budget], of_all[disturbance]))
                                      for budget in budgets]
            for disturbance in disturbances for selector in selectors}


def axes(budgets, ratios):
    ratios = [1.0, *(ratio for ratio in ratios if not math.isnan(ratio))]
    return (
        f"set logscale\nset xrange [{number(0.8 * budgets[0])}:{number(1.25 * budgets[-1])}]\n"
        f"set yrange [{number(0.9 * min(ratios))}:{number(1.1 * max(ratios))}]\n"
        "set ytics (0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 20, 50)\n"
        f"set xtics ({', '.join(number(budget) for budget in budgets)})\nunset key\n"
    )


def panel(disturbance, selectors):
    curves = [f"1 with lines {line_style('all')}",
              *(f"${disturbance}_{selector} with linespoints {line_style(selector)}" for selector in selectors)]
    return f"set title '{disturbance}' noenhanced\nplot " + ", \\\n".join(curves) + "\n"


def key(selectors):
    entries = [f"NaN with lines {line_style('all')} title 'all'",
               *(f"NaN with linespoints {line_style(selector)} title '{selector}' noenhanced" for selector in selectors)]
    return ("set key inside center center\nunset title\nunset border\nunset tics\nunset grid\nplot "
            + ", \\\n".join(entries) + "\n")


def pictures(settings, rows):
    disturbances, budgets = settings["disturbances"], sorted(settings["budgets"])
    selectors = list(dict.fromkeys(row["selector"] for row in rows if row["selector"] != "all"))
    panels = len(disturbances) + 1  # the last one holds the key
    columns = min(panels, MAX_COLUMNS)
    result = {}
    for name, column in ERRORS.items():
        curves = curves_of(rows, disturbances, selectors, budgets, column)
        blocks = "".join(data_block(f"{disturbance}_{selector}", points)
                         for (disturbance, selector), points in curves.items())
        result[f"robustness_{name}"] = Picture(1500, 1000, (
            blocks + STYLE + f"set multiplot layout {-(-panels // columns)},{columns} title 'RMS {name} error over the "
            f"budget, as a multiple of that of all {settings['matches']} matches'\n"
            + axes(budgets, [ratio for points in curves.values() for _, ratio in points])
            + "".join(panel(disturbance, selectors) for disturbance in disturbances) + key(selectors) + "unset multiplot\n"
        ))
    return result
