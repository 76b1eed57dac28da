# SPDX-License-Identifier: MIT
"""`maxlogdet_simulate euroc`: bars of mean errors by sequence. `maxlogdet_simulate budget`: box plots over budgets, with the median and
quartiles of all inliers."""

from maxlogdet_tools.gnuplot import STYLE, Picture, data_block, number
from maxlogdet_tools.pictures.quantiles import mean, quantile
from maxlogdet_tools.selector_styles import colour_of

ATE = ("ate_m", "ATE (m)")
RPE = ("rpe_m_per_s", "RPE (m/s)")
ROE = ("roe_deg_per_s", "ROE (deg/s)")
INLIERS = "'#d62020'"


def can_be_drawn(rows, column):
    """Trajectories shorter than a window have no relative errors."""
    return any(row[column] is not None for row in rows)


def unique(values):
    return list(dict.fromkeys(values))


def euroc(settings, rows):
    """A panel for each error, a group of bars for each sequence, a bar for each selector."""
    selectors = unique(row["selector"] for row in rows)
    sequences = unique(row["sequence"] for row in rows)
    blocks, panels = "", ""
    for place, (column, label) in enumerate((RPE, ROE, ATE), 1):
        if not can_be_drawn(rows, column):
            continue
        errors = lambda sequence, selector: mean(
            row[column] for row in rows if (row["sequence"], row["selector"]) == (sequence, selector))
        blocks += data_block(f"errors{place}", [[sequence, *(errors(sequence, selector) for selector in selectors)]
                                                for sequence in sequences])
        bars = (f"$errors{place} using {i}:xtic(1) with histograms fs solid lc rgb {colour_of(selector)} title '{selector}'"
                for i, selector in enumerate(selectors, 2))
        panels += f"set ylabel '{label}'\nplot " + ", ".join(bars) + "\n"
    return {"euroc": Picture(1300, 1100, (
        blocks + STYLE + "set style data histograms\nset style histogram clustered gap 1\nset yrange [0:*]\n"
        "set xtics rotate by -20\nset multiplot layout 3,1\n" + panels + "unset multiplot\n"
    ))}


def budget_panel(block, label, budgets, inliers, weighted):
    """`inliers`, `weighted`: errors of `inl` and `all_weighted`."""
    lower, median, upper = (number(quantile(inliers, share)) for share in (0.25, 0.5, 0.75))
    return (
        f"set xlabel 'features selected a frame'\nset ylabel '{label}'\n"
        f"set xrange [{number(min(budgets) - 8)}:{number(max(budgets) + 8)}]\nset boxwidth 6\nset yrange [*:*]\n"
        f"plot ${block} using 1:2:3:4:5 with candlesticks whiskerbars lc rgb {colour_of('quality_md')} "
        f"fs solid 0.4 title 'max_log_det', "
        f"${block} using 1:6:6:6:6 with candlesticks lc rgb '#804000' lw 2 notitle, "
        f"{median} lc rgb {INLIERS} lw 2 dt 2 title 'inl, median', "
        f"{lower} lc rgb {INLIERS} dt 3 title 'inl, quartiles', {upper} lc rgb {INLIERS} dt 3 notitle, "
        f"{number(quantile(weighted, 0.5))} lc rgb {colour_of('all_weighted')} lw 2 dt 2 title 'all weighted, median'\n"
    )


def budget(settings, rows):
    budgets = sorted(unique(row["budget"] for row in rows if row["budget"] > 0))
    blocks, panels = "", ""
    for place, (column, label) in enumerate((ATE, RPE, ROE), 1):
        if not can_be_drawn(rows, column):
            continue
        of = lambda holds: [row[column] for row in rows if holds(row)]
        boxes = []
        for k in budgets:  # lower quartile, minimum, maximum, upper quartile, median: as candlesticks take them
            errors = of(lambda row: row["budget"] == k)
            boxes.append([k, *(quantile(errors, share) for share in (0.25, 0, 1, 0.75, 0.5))])
        blocks += data_block(f"boxes{place}", boxes)
        panels += budget_panel(f"boxes{place}", label, budgets, of(lambda row: row["selector"] == "inl"),
                               of(lambda row: row["selector"] == "all_weighted"))
    runs = len({(row["sequence"], row["run"]) for row in rows})
    return {"budget": Picture(1300, 460, (
        blocks + STYLE + "set key bottom center outside horizontal\n"
        f"set multiplot layout 1,3 title '{rows[0]['sequence']}, {runs} runs'\n" + panels + "unset multiplot\n"
    ))}
