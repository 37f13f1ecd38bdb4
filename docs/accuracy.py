#!/usr/bin/env python3
"""accuracy.py FOLDER: prints, from the sweeps in FOLDER, the tables of docs/accuracy.md: which presets are on
the Pareto front and what each setting alone buys."""
import csv
import math
import pathlib
import sys


def points(path):
    rows = list(csv.DictReader(path.open()))
    for row in rows:
        row["seconds"], row["error"] = float(row["seconds"]), float(row["error"])
        row["knobs"] = dict(pair.split("=") for pair in row["settings"].split())
    return rows


def exponent(line):
    logs = [(math.log(r["seconds"]), math.log(r["error"])) for r in line if r["error"] > 0]
    if len(logs) < 2:
        return None
    mx, my = (sum(v) / len(logs) for v in zip(*logs))
    xx = sum((x - mx) ** 2 for x, _ in logs)
    return -sum((x - mx) * (y - my) for x, y in logs) / xx if xx / len(logs) > 0.01 else None


def main():
    folder = pathlib.Path(sys.argv[1])
    sweeps = {p.parent.name: points(p) for p in sorted(folder.glob("*/sweep.csv"))}
    print("| sweep | preset | rms | seconds | least time for that error | least error in that time |")
    print("|---|---|---|---|---|---|")
    for name, rows in sweeps.items():
        for row in rows:
            if row["preset"]:
                quick = min(r["seconds"] for r in rows if r["error"] <= row["error"] * 1.0001)
                good = min(r["error"] for r in rows if r["seconds"] <= row["seconds"] * 1.0001)
                print(f"| {name} | {row['preset']} | {row['error']:.2%} | {row['seconds']:.2f} "
                      f"| {quick:.2f} | {good:.2%} |")
    print("\n| sweep | setting | exponent | values: rms in seconds |")
    print("|---|---|---|---|")
    for name, rows in sweeps.items():
        normal = next((r for r in rows if r["preset"] == "normal"), None)
        for knob in normal["knobs"] if normal else []:
            same = [r for r in rows if all(r["knobs"][k] == v for k, v in normal["knobs"].items() if k != knob)]
            if len(same) > 1:
                p = exponent(same)
                values = "; ".join(f"{r['knobs'][knob]}: {r['error']:.2%} in {r['seconds']:.2f}" for r in same)
                print(f"| {name} | {knob} | {'-' if p is None else f'{p:.2f}'} | {values} |")


if __name__ == "__main__":
    main()
