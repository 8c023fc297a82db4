#!/usr/bin/env python3
"""Draws figures from the results of softcd-bench (its --json file, or CSV files).

Needs matplotlib: apt-get install python3-matplotlib, or pip install matplotlib.
"""

import argparse
import csv
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

COLOURS = {
    "conservative": "#1b7837",
    "precise": "#2166ac",
    "fast": "#92c5de",
    "bullet": "#b2182b",
    "dcd": "#e08214",
    "ccd": "#1b7837",
    "ccd, edges": "#762a83",
}
SUBSTEPS = ("dcd-1", "dcd-2", "dcd-4", "dcd-8", "dcd-16")
CONTINUOUS = ("fast", "precise", "conservative")
# If two modes coincide, the smaller marker lies on the larger one.
MARKERS = {"precise": ("s", 75), "conservative": ("o", 28), "fast": ("^", 55)}
LABEL = {"fontsize": 7, "textcoords": "offset points"}


def number(text):
    """Returns the value of a CSV field: a number, None where it is empty, or else the text."""
    if text == "":
        return None
    try:
        return float(text) if any(c in text for c in ".eE") else int(text)
    except ValueError:
        return text


def load(paths):
    """Returns the results of all files together: lists of rows, and the description of the run."""
    results = {}
    for path in paths:
        if path.suffix == ".csv":
            with path.open(newline="") as file:
                rows = [
                    {key: number(value) for key, value in row.items()}
                    for row in csv.DictReader(file)
                ]
            results.setdefault(path.stem, []).extend(rows)
            continue
        for key, value in json.loads(path.read_text()).items():
            if isinstance(value, list):
                results.setdefault(key, []).extend(value)
            else:
                results[key] = value
    return results


def described(results):
    parts = [results.get("machine"), results.get("date"), results.get("compiler")]
    return "; ".join(str(part) for part in parts if part)


def grouped(rows, *keys):
    """Returns rows grouped by the values of the keys. Groups are in the order of their first rows."""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def cost_scale(axes):
    """Sets a logarithmic scale with few labels."""
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major", color="#dddddd", linewidth=0.6)
    axes.margins(x=0.2)


def percent_scale(axes):
    """Sets a logarithmic scale with a place for 0."""
    axes.set_yscale("symlog", linthresh=1e-3, linscale=0.4)
    axes.set_ylim(-6e-4, 400)
    axes.set_yticks([0, 1e-3, 1e-2, 1e-1, 1, 10, 100])
    axes.set_yticklabels(["none", "0.001", "0.01", "0.1", "1", "10", "100"])


def count_scale(axes, most):
    """Sets a logarithmic scale of counts with a place for 0."""
    axes.set_yscale("symlog", linthresh=1, linscale=0.4)
    axes.set_ylim(-0.4, 3 * max(most, 10))
    ticks = [0] + [10**i for i in range(6) if 10**i <= 3 * max(most, 10)]
    axes.set_yticks(ticks, ["none"] + [str(tick) for tick in ticks[1:]])


def pareto(axes, points):
    """Draws points by mode. A line joins the substeps of discrete detection."""
    chain = [points[mode] for mode in SUBSTEPS if mode in points]
    axes.plot(*zip(*chain), color=COLOURS["dcd"], linewidth=1, zorder=2)
    for mode, (x, y) in points.items():
        marker, size = MARKERS.get(mode, ("o", 45))
        colour = COLOURS[mode.split("-")[0]]
        order = 5 - size / 100
        axes.scatter([x], [y], s=size, marker=marker, color=colour, zorder=order)
        if mode not in CONTINUOUS:
            axes.annotate(mode, (x, y), xytext=(4, 4), **LABEL)
    cost_scale(axes)


def mode_legend(figure, modes):
    handles = [
        Line2D(
            [],
            [],
            marker=MARKERS.get(mode, ("o", 45))[0],
            linestyle="",
            color=COLOURS[mode],
            label=label,
        )
        for mode, label in modes
    ]
    figure.legend(handles=handles, loc="lower center", ncols=len(modes), fontsize=8)


def grid_of_axes(count, columns, width=3.4, height=2.9):
    rows = -(-count // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(width * columns, height * rows), squeeze=False
    )
    flat = [axis for row in axes for axis in row]
    for axis in flat[count:]:
        axis.axis("off")
    return figure, flat


def share(part, whole):
    return 100 * part / whole if whole else 0


MODE_LABELS = (
    ("fast", "fast"),
    ("precise", "precise"),
    ("conservative", "conservative"),
    ("bullet", "Bullet's test (vertex-triangle)"),
    ("dcd", "dcd-N: discrete, N substeps, margin a tenth of an edge"),
)


def draw_queries(results):
    """Draws missed contacts and errors of the time of impact over the time per query."""
    sets = [
        rows
        for rows in grouped(results["queries"], "set", "kind").values()
        if rows[0]["touching"] >= 1000
    ]
    figure, axes = grid_of_axes(2 * len(sets), 4)
    for rows, missed, error in zip(sets, axes[::2], axes[1::2]):
        touching = rows[0]["touching"]
        title = f"{rows[0]['set']}, {rows[0]['kind']}: {touching} touch"
        points = {
            row["mode"]: (row["ns_per_query"], share(row["missed"], touching))
            for row in rows
        }
        pareto(missed, points)
        percent_scale(missed)
        missed.set_ylabel("missed, %")
        points = {
            row["mode"]: (
                row["ns_per_query"],
                max(row["early_999"] or 1e-16, row["late_999"] or 1e-16),
            )
            for row in rows
            if row["mode"] != "bullet"
        }
        pareto(error, points)
        error.set_yscale("log")
        error.set_ylim(1e-14, 20)
        error.set_ylabel("error of the time, 99.9 %, in steps")
        for axis in (missed, error):
            axis.set_title(title, fontsize=8)
            axis.set_xlabel("ns per query")
    mode_legend(figure, MODE_LABELS)
    return figure


def draw_steps(results):
    """Draws missed contacts over the milliseconds of whole detections."""
    groups = grouped(results["steps"], "scene", "features", "backend")
    figure, axes = grid_of_axes(len(groups), 4)
    for axis, ((scene, features, backend), rows) in zip(axes, groups.items()):
        touching = rows[0]["touching"]
        points = {
            row["mode"]: (row["ms"], share(row["missed"], touching)) for row in rows
        }
        pareto(axis, points)
        percent_scale(axis)
        axis.set_title(f"{scene}, {features}, {backend}: {touching} touch", fontsize=8)
        axis.set_xlabel("ms per step")
        axis.set_ylabel("missed, %")
    mode_legend(figure, [label for label in MODE_LABELS if label[0] != "bullet"])
    return figure


DETECTION_LABELS = (
    ("bullet", "Bullet's own detection"),
    ("dcd", "softcd, dcd"),
    ("ccd", "softcd, ccd"),
    ("ccd, edges", "softcd, ccd, edges too"),
)


def cost_of(results):
    """Returns the column that simulations are compared by, and its label."""
    if results["processor_time"]:
        return "processor_ms_per_second", "processor ms per simulated second"
    return "ms_per_second", "ms per simulated second"


def draw_simulation(results):
    """Draws vertices on the wrong side over the cost of a simulated second, by time step."""
    cost, cost_label = cost_of(results)
    groups = grouped(results["simulation"], "scene", "world", "backend")
    figure, axes = grid_of_axes(len(groups), 2, width=5, height=3.4)
    for axis, ((scene, world, backend), rows) in zip(axes, groups.items()):
        sweep = [row for row in rows if row["knob"] == "time step"]
        wrong = [row["tunnelled"] + row["most_penetrating"] for row in sweep]
        lines = grouped(sweep, "detection", "features")
        for place, ((detection, features), line) in enumerate(lines.items()):
            name = f"{detection}, edges" if "ee" in features else detection
            # Points on the axis differ by their places around "none".
            none = 0.2 - 0.15 * place
            x = [row[cost] for row in line]
            y = [row["tunnelled"] + row["most_penetrating"] or none for row in line]
            style = {"color": COLOURS[name], "marker": "o", "markersize": 4}
            axis.plot(x, y, linewidth=1, **style)
            for row, point in zip(line, zip(x, y)):
                if row is line[0] or row is line[-1] or point[1] > 1:
                    axis.annotate(row["value"], point, xytext=(2, 4), **LABEL)
        count_scale(axis, max(wrong))
        cost_scale(axis)
        title = f"{scene}, {world} world, {backend}: {rows[0]['vertices']} vertices"
        axis.set_title(title, fontsize=8)
        axis.set_xlabel(cost_label)
        axis.set_ylabel("vertices: tunnelled + most penetrating")
    mode_legend(figure, DETECTION_LABELS)
    return figure


def is_base(row):
    """Returns whether the row is the base point, which the changes of options start from."""
    return (row["detection"], row["features"], row["value"]) == ("ccd", "vt", "1/120")


def draw_knobs(results):
    """Draws the effect of each changed option, relative to the base point of the same scene."""
    cost, cost_label = cost_of(results)
    groups = grouped(results["simulation"], "scene", "world", "backend")
    figure, axes = grid_of_axes(len(groups), 2, width=5, height=3.2)
    for axis, ((scene, world, backend), rows) in zip(axes, groups.items()):
        base = next(row for row in rows if is_base(row))
        turned = [row for row in rows if row["knob"] != "time step"]
        turned += [
            {**row, "knob": "features", "value": "vt,ee"}
            for row in rows
            if row["features"] == "vt,ee" and row["value"] == "1/120"
        ]
        places = range(len(turned))
        ratios = [row[cost] / base[cost] for row in turned]
        axis.barh(places, ratios, color="#92c5de")
        for place, row in zip(places, turned):
            wrong = f"{row['tunnelled']} tunnelled, {row['most_penetrating']} penetrate"
            text = f"{wrong}, {row['contacts']:.0f} contacts"
            axis.annotate(text, (0, place), xytext=(3, -3), **LABEL)
        axis.axvline(1, color="#555555", linewidth=0.8)
        labels = [f"{row['knob']} {row['value']}" for row in turned]
        axis.set_yticks(places, labels, fontsize=7)
        axis.invert_yaxis()
        axis.set_title(f"{scene}, {world} world, {backend}", fontsize=8)
        axis.set_xlabel(f"{cost_label} / that of the base point")
    return figure


# A figure is drawn from the results that it needs: name, key of the rows, function.
STAGES = (
    "volumes",
    "subdivision",
    "assignment",
    "sort",
    "tests",
    "features",
    "narrow",
)


def draw_scenes(results):
    """Draws the time of a detection of each scene, beside the paper's (its Table 1), and its stages (its Fig. 15)."""
    rows = [row for row in results["simulated_scenes"] if row["detection"] == "ccd"]
    scenes = grouped(rows, "scene")
    paper = {row["scene"]: row["ccd_ms"] for row in results.get("paper", [])}
    names = [name for (name,) in scenes]
    figure, (times, shares) = plt.subplots(1, 2, figsize=(9, 0.4 * len(names) + 1.6))
    backends = [backend for (backend,) in grouped(rows, "backend")]
    bars = [("paper, GTX 470", "#999999")] + list(zip(backends, ("#1b7837", "#2166ac")))
    height = 0.8 / len(bars)
    for i, (bar, colour) in enumerate(bars):
        values = []
        for name in names:
            of_scene = [row["ms"] for row in scenes[(name,)] if row["backend"] == bar]
            work = [ms["total"] - ms["transfer"] for ms in of_scene]
            values.append(sum(work) / len(work) if work else paper.get(name, 0))
        places = [place + i * height for place in range(len(names))]
        times.barh(places, values, height, color=colour, label=bar)
    times.set_yticks([place + 0.4 - height / 2 for place in range(len(names))], names)
    times.invert_yaxis()
    times.set_xscale("log")
    times.set_xlabel("milliseconds of a continuous detection")
    times.legend(fontsize=7)
    colours = plt.get_cmap("tab10")
    for place, name in enumerate(names):
        of_scene = [
            row["ms"] for row in scenes[(name,)] if row["backend"] == backends[0]
        ]
        spent = [sum(ms[stage] for ms in of_scene) for stage in STAGES]
        left = 0
        for i, (stage, part) in enumerate(zip(STAGES, spent)):
            width = share(part, sum(spent))
            label = stage if place == 0 else None
            shares.barh(place, width, 0.7, left, color=colours(i), label=label)
            left += width
    shares.set_yticks([])
    shares.invert_yaxis()
    shares.set_xlabel(f"per cent of it, {backends[0]}")
    figure.legend(*shares.get_legend_handles_labels(), loc="lower center", ncols=7)
    return figure


def draw_history(results):
    """Draws the time of each scene in continuous detection by release, for each machine."""
    rows = [row for row in results["history"] if row["mode"] == "ccd precise"]
    machines = grouped(rows, "machine")
    figure, plots = plt.subplots(
        1, len(machines), figsize=(4.5 * len(machines), 3.6), squeeze=False
    )
    for plot, ((machine,), of_machine) in zip(plots[0], machines.items()):
        dates = sorted({(row["date"], row["version"]) for row in of_machine})
        place = {version: i for i, (_, version) in enumerate(dates)}
        for (scene,), its in grouped(of_machine, "scene").items():
            its.sort(key=lambda row: place[row["version"]])
            x = [place[row["version"]] for row in its]
            below = [max(row["ms"] - row["ms_first_quartile"], 0) for row in its]
            above = [max(row["ms_third_quartile"] - row["ms"], 0) for row in its]
            ms = [row["ms"] for row in its]
            plot.errorbar(
                x, ms, (below, above), marker="o", markersize=4, capsize=2, label=scene
            )
        plot.set_xticks(range(len(dates)), [version for _, version in dates])
        plot.set_yscale("log")
        plot.set_ylabel("milliseconds of a detection, ccd precise")
        plot.set_title(machine, fontsize=8)
        plot.legend(fontsize=6)
    return figure


FIGURES = (
    ("trade-queries", "queries", draw_queries),
    ("trade-steps", "steps", draw_steps),
    ("trade-simulation", "simulation", draw_simulation),
    ("trade-knobs", "simulation", draw_knobs),
    ("scenes", "simulated_scenes", draw_scenes),
    ("history", "history", draw_history),
)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "results", nargs="+", type=Path, help="files of --json, or CSV files"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("."), help="folder for the figures"
    )
    parser.add_argument("--format", choices=("svg", "png"), default="svg")
    parser.add_argument(
        "--figure", choices=[name for name, _, _ in FIGURES], help="one figure only"
    )
    parser.add_argument(
        "--processor-time",
        action="store_true",
        help="compare simulations by the processor's time, for machines that are shared",
    )
    options = parser.parse_args()
    matplotlib.rcParams.update(
        {"svg.hashsalt": "softcd", "svg.fonttype": "none", "font.size": 8}
    )
    try:
        results = load(options.results)
        options.out.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        sys.exit(f"report.py: {error}")
    results["processor_time"] = options.processor_time
    drawn = 0
    for name, key, draw in FIGURES:
        if key not in results or options.figure not in (None, name):
            continue
        figure = draw(results)
        figure.suptitle(described(results), fontsize=7, color="#555555", y=0.995)
        figure.tight_layout(rect=(0, 0.04, 1, 1))
        path = options.out / f"{name}.{options.format}"
        figure.savefig(
            path, dpi=110, metadata={"Date": None} if options.format == "svg" else None
        )
        plt.close(figure)
        print(path)
        drawn += 1
    if drawn == 0:
        sys.exit("report.py: the results have nothing that a figure is drawn from")


if __name__ == "__main__":
    main()
