# SPDX-License-Identifier: MIT
"""The pictures of each kind of data: what programs write, as gnuplot scripts."""

from maxlogdet_tools.gnuplot import STYLE, Colour, Picture, data_block, number, quoted

# Line and point of a metric or selector, the same in every picture.
STYLES = {
    "max_log_det": (Colour.VERMILION, "dt 1 lw 2.5 pt 7"),
    "max_trace": (Colour.BLUE, "dt 1 lw 1.5 pt 5"),
    "min_condition": (Colour.GREEN, "dt 1 lw 1.5 pt 9"),
    "max_min_eigenvalue": (Colour.PURPLE, "dt 1 lw 1.5 pt 11"),
    "random": ("#808080", "dt 3 lw 1.5 pt 1"),
    "all": (Colour.BLACK, "dt 1 lw 2 pt 3"),
}
# Of `maxlogdet evaluate`, in the order of the key.
COLOURS = {"md": Colour.VERMILION, "md_spread": Colour.PURPLE, "md_ungated": Colour.ORANGE, "bucket_gated": Colour.GREEN,
           "random_gated": Colour.BLUE, "random": "#808080", "aligned": Colour.SKY_BLUE}
WRONG = "#ff3020"  # wrong matches, crosses


# `maxlogdet_simulate metrics`: RMS errors over the subset size, four panels as in the paper


def metrics(rows):
    """`rows`: those of metrics.csv."""
    columns = ("size", "rms_translation_m", "ci95_of_rms_translation_m", "rms_rotation_deg", "ci95_of_rms_rotation_deg")
    selectors = list(dict.fromkeys(row["selector"] for row in rows))
    blocks, panels = "", ""
    for noise in dict.fromkeys(row["noise_px"] for row in rows):
        for selector in selectors:
            chosen = [row for row in rows if row["noise_px"] == noise and row["selector"] == selector]
            blocks += data_block(f"{selector}_{noise}", [[row[column] for column in columns] for row in chosen])
        for label, value in (("RMS translation error (m)", 2), ("RMS rotation error (deg)", 4)):
            curves = []
            for selector in selectors:
                colour, line = STYLES[selector]
                using, kind = (f"1:{value}", "lines") if selector == "all" else (f"1:{value}:{value + 1}", "yerrorlines")
                curves.append(f"${selector}_{noise} using {using} with {kind} lc rgb '{colour}' {line} ps 0.7 "
                              f"title '{selector}'")
            panels += f"set title 'noise {noise} px'\nset ylabel '{label}'\nplot " + ", \\\n".join(curves) + "\n"
    return Picture(1200, 800, (
        blocks + STYLE + "set multiplot layout 2,2 title 'bars: 95 % confidence'\nset xlabel 'subset size'\n"
        + panels + "unset multiplot\n"
    ))


# `maxlogdet evaluate`: growth of the standard deviation over the budget, with what the model predicts

PARTS = ("translation", "rotation")
TICS = [digit * 10.0**power for power in range(-4, 5) for digit in (1, 2, 5)]


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
        block, colour = f"${part}_{selector}", f"lc rgb '{COLOURS[selector]}'"
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
    points = {(part, selector): points_of(rows, selector, part, budgets) for part in PARTS for selector in COLOURS}
    selectors = [name for name in COLOURS if any(points[part, name] for part in PARTS)]
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


# `maxlogdet demo --plot-data`: the chosen matches of a frame as the camera sees them, one panel for each way to choose


def choices(data):
    """`data`: what cli/demo_command.cpp writes."""
    pixels, is_wrong = list(zip(data["u_px"], data["v_px"])), data["is_wrong"]
    width, height = data["width_px"], data["height_px"]
    blocks, panels = data_block("every", pixels), ""
    for number_of, choice in enumerate(data["choices"]):
        parts = [[pixels[i] for i in choice["matches"] if is_wrong[i] == wrong] for wrong in (False, True)]
        blocks += data_block(f"correct_{number_of}", parts[0]) + data_block(f"wrong_{number_of}", parts[1])
        title = (f"{choice['name']}: {len(parts[0])} correct, {len(parts[1])} wrong; "
                 f"error of the position {choice['position_error']:.2f}")
        panels += (f"set title {quoted(title)}\nplot $every with points pt 7 ps 0.2 lc rgb '#c0c0c0' notitle, "
                   f"$correct_{number_of} with points pt 7 ps 0.5 lc rgb '{Colour.BLUE}' notitle, "
                   f"$wrong_{number_of} with points pt 2 ps 0.9 lw 2 lc rgb '{WRONG}' notitle\n")
    title_of_all = ("One of the frames: chosen matches, correct ones blue and wrong ones red; the others grey. "
                    "Errors: root mean square of all frames, where all matches have 1")
    return Picture(1200, 520, (
        f"{blocks}set multiplot layout 2,2 title {quoted(title_of_all)}\n"
        f"unset tics\nset xrange [0:{width}]\nset yrange [{height}:0]\nset size ratio {number(height / width)}\n"
        f"{panels}unset multiplot\n"
    ))
