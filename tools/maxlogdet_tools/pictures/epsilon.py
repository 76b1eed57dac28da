# SPDX-License-Identifier: MIT
"""`maxlogdet_simulate epsilon`: heat maps over k / n and epsilon, one for each size; a picture for each of three quantities."""

from maxlogdet_tools.gnuplot import STYLE, Picture, data_block, number
from maxlogdet_tools.pictures.quantiles import mean


def with_few_digits(value):
    return f"{value:.{1 if value < 10 else 0}f}"


# Name of the picture: its title, the darkest colour, a row's value, and how a mean is shown.
MAPS = {
    "epsilon_time": ("time of a selection (us)", "#6baed6", lambda row: row["us"], with_few_digits),
    "epsilon_gap": ("log det below greedy (nats)", "#fc8d59", lambda row: row["gap_nats"], lambda value: f"{value:.3f}"),
    "epsilon_differing": ("features that greedy does not select (%)", "#fc8d59",
                          lambda row: 100 * row["differing"] / row["k"], with_few_digits),
}


def cells_of(rows, shares, epsilons, value, shown):
    """(place of the share, place of the epsilon, mean over runs, its text) of one size."""
    cells = {}
    seen = {}
    for row in rows:  # a run's rows are in order of shares and epsilons
        place = seen.setdefault(row["run"], 0)
        seen[row["run"]] += 1
        cells.setdefault(place, []).append(value(row))
    means = {place: mean(values) for place, values in sorted(cells.items())}
    return [(place // len(epsilons), place % len(epsilons), m, shown(m)) for place, m in means.items()]


def tics(labels):
    return ", ".join(f"'{label}' {place}" for place, label in enumerate(labels))


def pictures(settings, rows):
    sizes, shares, epsilons = settings["sizes"], settings["shares"], settings["epsilons"]
    columns = min(3, len(sizes))
    result = {}
    for name, (title, colour, value, shown) in MAPS.items():
        blocks, panels = "", ""
        for i, n in enumerate(sizes):
            of_size = [row for row in rows if row["n"] == n]
            blocks += data_block(f"map{i}", cells_of(of_size, shares, epsilons, value, shown))
            panels += (f"set title 'n = {n}'\nplot $map{i} using 1:2:3 with image, "
                       f"$map{i} using 1:2:4 with labels font ',9' notitle\n")
        result[name] = Picture(1300, 760, (
            blocks + STYLE + "unset key\nunset colorbox\nunset grid\nset tics scale 0\n"
            f"set palette defined (0 '#f7fbff', 1 '{colour}')\nset xlabel 'k / n (%)'\nset ylabel 'ε'\n"
            f"set xtics ({tics(f'{100 * share:.0f}' for share in shares)})\n"
            f"set ytics ({tics(number(epsilon) for epsilon in epsilons)})\n"
            f"set xrange [-0.5:{len(shares) - 1}.5]\nset yrange [-0.5:{len(epsilons) - 1}.5]\n"
            f"set multiplot layout {-(-len(sizes) // columns)},{columns} title 'stochastic greedy: {title}'\n"
            + panels + "unset multiplot\n"
        ))
    return result
