#!/ usr / bin / env python3
""
    "Draws figures from the results of softcd-bench (its --json file, or CSV files)."
    ""

    import argparse import csv import json import sys from pathlib import Path

        import matplotlib

            matplotlib.use("Agg") import matplotlib.pyplot as plt

    COLOURS = {
  "conservative" : "#1b7837",
  "precise" : "#2166ac",
  "fast" : "#92c5de",
  "bullet" : "#b2182b",
  "dcd" : "#e08214",
  "ccd" : "#1b7837",
} SUBSTEPS = ("dcd-1", "dcd-2", "dcd-4", "dcd-8", "dcd-16")CONTINUOUS = ("fast", "precise", "conservative")SCATTER = {
  "s" : 55,
  "zorder" : 3,
  "edgecolor" : "white",
  "linewidth" : 0.6
} LABEL = {"fontsize" : 7, "textcoords" : "offset points"}

          def number(text)
    : ""
      "A CSV field: a number, None where it is empty, or else the text."
      "" if text
      == "" : return None try:
        return float(text) if any(c in text for c in ".eE") else int(text)
    except ValueError:
        return text


def load(paths):
    """The results of all files together: lists of rows, and what describes the run."""
    results = {}
    for path in paths:
        if path.suffix == ".csv":
            with path.open(newline="") as file:
                rows = [
                    {
  key: number(value) for key, value in row.items()}
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
    """Rows by the values of the keys, in the order of their first row."""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def percent_scale(axes):
    """A logarithmic scale with a place for 0."""
    axes.set_yscale("symlog", linthresh=1e-3, linscale=0.4)
    axes.set_ylim(-3e-4, 150)
    axes.set_yticks([0, 1e-3, 1e-2, 1e-1, 1, 10, 100])
    axes.set_yticklabels(["none", "0.001", "0.01", "0.1", "1", "10", "100"])


def count_scale(axes):
    """The same for counts."""
    axes.set_yscale("symlog", linthresh=1, linscale=0.4)
    axes.set_ylim(bottom=-0.3)


def mark(axes, x, y, mode, shift=(5, 4)):
    axes.scatter([x], [y], color=COLOURS[mode.split("-")[0]], **SCATTER)
    axes.annotate(mode, (x, y), xytext=shift, **LABEL)


def pareto(axes, points):
    """Points by mode; the substeps of discrete detection are joined."""
    chain = [points[mode] for mode in SUBSTEPS if mode in points]
    axes.plot(*zip(*chain), color=COLOURS["dcd"], linewidth=1, zorder=2)
    shifts = {"fast": (5, 14), "precise": (5, 4), "conservative": (5, -9)}
    for mode, (x, y) in points.items():
        mark(axes, x, y, mode, shifts.get(mode, (5, 4)))
    axes.set_xscale("log")
    axes.grid(True, which="major", color="#dddddd", linewidth=0.6)


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


def draw_queries(results):
    """Missed contacts and errors of the time of impact over the time per query."""
    sets = {
  key: rows
        for key, rows in grouped(results["queries"], "set", "kind").items()
        if rows[0]["touching"] >= 1000
    }
    figure, axes = grid_of_axes(2 * len(sets), len(sets), width=2.9)
    for column, ((name, kind), rows) in enumerate(sets.items()):
        missed, error = axes[column], axes[column + len(sets)]
        pareto(
            missed,
            {
                row["mode"]: (
                    row["ns_per_query"],
                    share(row["missed"], row["touching"]),
                )
                for row in rows
            },
        )
        percent_scale(missed)
        missed.set_title(
            f"{name}, {kind.upper()}\n{rows[0]['touching']} touch", fontsize=8
        )
        pareto(
            error,
            {
                row["mode"]: (
                    row["ns_per_query"],
                    max(row["early_999"] or 1e-16, row["late_999"] or 1e-16),
                )
                for row in rows
                if row["mode"] != "bullet"
            },
        )
        error.set_yscale("log")
        error.set_ylim(1e-14, 5)
        error.set_xlabel("ns per query")
    axes[0].set_ylabel("missed, % of what touches")
    axes[len(sets)].set_ylabel(
        "time of impact: 99.9 % within\n(steps; the larger of early, late)"
    )
    return figure


def draw_steps(results):
    """Missed contacts over the milliseconds of whole detections."""
    groups = grouped(results["steps"], "scene", "features", "backend")
    figure, axes = grid_of_axes(len(groups), 4)
    for axis, ((scene, features, backend), rows) in zip(axes, groups.items()):
        pareto(
            axis,
            {
                row["mode"]: (row["ms"], share(row["missed"], row["touching"]))
                for row in rows
            },
        )
        percent_scale(axis)
        axis.set_title(
            f"{scene}, {features}, {backend}: {rows[0]['touching']} touch", fontsize=8
        )
        axis.set_xlabel("ms per step")
        axis.set_ylabel("missed, %")
    return figure


def draw_simulation(results):
    """Vertices on the wrong side over the cost of a simulated second, by time step."""
    groups = grouped(results["simulation"], "scene", "backend")
    figure, axes = grid_of_axes(len(groups), 2, width=5, height=3.6)
    for axis, ((scene, backend), rows) in zip(axes, groups.items()):
        sweep = [row for row in rows if row["knob"] == "time step"]
        for (detection,), line in grouped(sweep, "detection").items():
            x = [row["ms_per_second"] for row in line]
            y = [row["tunnelled"] + row["most_penetrating"] for row in line]
            axis.plot(
                x,
                y,
                color=COLOURS[detection],
                marker="o",
                markersize=5,
                label=detection,
            )
            for row, point in zip(line, zip(x, y)):
                axis.annotate(row["value"], point, xytext=(4, 4), **LABEL)
        axis.set_xscale("log")
        count_scale(axis)
        axis.grid(True, which="major", color="#dddddd", linewidth=0.6)
        axis.set_title(
            f"{scene}, {backend}: {rows[0]['vertices']} vertices", fontsize=9
        )
        axis.set_xlabel("ms per simulated second")
        axis.set_ylabel("vertices: tunnelled + most penetrating")
        axis.legend(fontsize=8)
    return figure


def draw_knobs(results):
    """What each dial changes, relative to the base point of the same scene."""
    rows = results["simulation"]
    groups = grouped(rows, "scene", "backend")
    figure, axes = grid_of_axes(len(groups), 2, width=5, height=4)
    for axis, ((scene, backend), runs) in zip(axes, groups.items()):
        base = next(
            row
            for row in runs
            if row["detection"] == "ccd" and row["steps_per_second"] == 120
        )
        turned = [row for row in runs if row["knob"] != "time step"]
        places = range(len(turned))
        axis.barh(
            places,
            [row["ms_per_second"] / base["ms_per_second"] for row in turned],
            color="#92c5de",
        )
        for place, row in zip(places, turned):
            axis.annotate(
                f"{row['tunnelled']} tunnelled, {row['most_penetrating']} penetrating",
                (0, place),
                xytext=(3, -3),
                **LABEL,
            )
        axis.axvline(1, color="#555555", linewidth=0.8)
        axis.set_yticks(
            places, [f"{row['knob']} {row['value']}" for row in turned], fontsize=7
        )
        axis.invert_yaxis()
        axis.set_title(f"{scene}, {backend}", fontsize=9)
        axis.set_xlabel("cost / cost of the base point")
    return figure

#A figure is drawn from the results that it needs : name, key of the rows, function.
FIGURES = (
    ("trade-queries", "queries", draw_queries),
    ("trade-steps", "steps", draw_steps),
    ("trade-simulation", "simulation", draw_simulation),
    ("trade-knobs", "simulation", draw_knobs),
)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
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
    options = parser.parse_args()
    matplotlib.rcParams.update({"svg.hashsalt": "softcd", "font.size": 8})
    try:
        results = load(options.results)
        options.out.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        sys.exit(f"report.py: {error}")
    drawn = 0
    for name, key, draw in FIGURES:
        if key not in results or options.figure not in (None, name):
            continue
        figure = draw(results)
        figure.suptitle(described(results), fontsize=7, color="#555555")
        figure.tight_layout()
        path = options.out / f"{name}.{options.format}"
        figure.savefig(
            path, dpi=110, metadata={
    "Date" : None} if options.format == "svg" else None
        )
        plt.close(figure)
        print(path)
        drawn += 1
    if drawn == 0:
        sys.exit("report.py: the results have nothing that a figure is drawn from")


if __name__ == "__main__":
    main()
