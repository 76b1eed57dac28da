# SPDX-License-Identifier: MIT
"""`maxlogdet evaluate`: growth of the standard deviation over the budget, with what the model predicts; and chi-squared
by leverage."""

from maxlogdet_tools.gnuplot import STYLE, Picture, data_block, number
from maxlogdet_tools.selector_styles import colour_of

PARTS = ("translation", "rotation")
TICS = [digit * 10.0**power for power in range(-4, 5) for digit in (1, 2, 5)]
SHOWN = ("md", "md_spread", "md_ungated", "bucket_gated", "random_gated", "random", "aligned")


def points_of(rows, selector, part, budgets):
    """[(budget, growth, low, high, predicted)] of a selector, by budget; without one, at the smallest and largest."""
    found = []
    for row in rows:
        growth = row[f"{part}_growth_percent"]
        if row["selector"] == selector and growth["value"]:
            values = [growth[key] for key in ("value", "low", "high", "predicted")]
            found += [(at, *values) for at in ([row["budget"]] if row["has_budget"] else (budgets[0], budgets[-1]))]
    return sorted(found)


def panel(part, selectors, points, has_key):
    curves = []
    for selector in selectors:
        block, colour = f"${part}_{selector}", f"lc rgb {colour_of(selector)}"
        curves += [f"{block} using 1:2:3:4 with yerrorbars {colour} lw 1 pt 0 notitle",
                   f"{block} using 1:2 with linespoints {colour} lw 2 pt 7 ps 0.5 title '{selector}'",
                   f"{block} using 1:5 with lines {colour} dt 3 lw 1.5 notitle"]
    values = [value for selector in selectors for point in points[part, selector] for value in point[1:4]
              if value and value > 0]
    low, high = (0.8 * min(values), 1.25 * max(values)) if values else (1, 10)
    tics = ", ".join(number(tic) for tic in TICS if low <= tic <= high)
    return (f"set yrange [{number(low)}:{number(high)}]\nset ytics ({tics})\nset ylabel '{part} (%)'\n"
            + ("set key outside right center\n" if has_key else "unset key\n")
            + "plot " + ", \\\n".join(curves) + "\n")


def deviation(data):
    """`data`: what `maxlogdet evaluate --output` writes as evaluation.json."""
    rows = data["selectors"]
    budgets = sorted({row["budget"] for row in rows if row["has_budget"]})
    points = {(part, selector): points_of(rows, selector, part, budgets) for part in PARTS for selector in SHOWN}
    selectors = [name for name in SHOWN if any(points[part, name] for part in PARTS)]
    blocks = "".join(data_block(f"{part}_{selector}", points[part, selector])
                     for part in PARTS for selector in selectors)
    title = (f"Growth of the pose''s standard deviation over that with all {data['inliers']:.0f} inliers, "
             f"{data['frames']} frames; dotted: predicted without wrong matches")
    return Picture(1100, 430, (
        blocks + STYLE + "set logscale xy\nset xlabel 'matches'\n"
        f"set xrange [{number(0.85 * budgets[0])}:{number(1.18 * budgets[-1])}]\n"
        f"set xtics ({', '.join(number(budget) for budget in budgets)})\n"
        f"set multiplot layout 1,2 title '{title}'\n"
        + "".join(panel(part, selectors, points, part == "rotation") for part in PARTS)
        + "unset multiplot\n"
    ))


def leverage(data):
    rows = [(decile + 1, chi2["value"], chi2["low"], chi2["high"])
            for decile, chi2 in enumerate(data["chi2_by_leverage"])]
    return Picture(600, 360, (
        data_block("chi2", rows) + STYLE
        + "set xlabel 'tenth of the matches by leverage, lowest to highest'\nset ylabel 'chi-squared (1: as modelled)'\n"
        "set yrange [0:*]\nset xrange [0.5:10.5]\nset xtics 1\nunset key\nset style fill solid 0.4\n"
        f"plot $chi2 using 1:2 with boxes lc rgb {colour_of('bucket')}, "
        "$chi2 using 1:2:3:4 with yerrorbars lc rgb '#000000' pt 0, 1 with lines lc rgb '#000000' dt 2\n"
    ))
