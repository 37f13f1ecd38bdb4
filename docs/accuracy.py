#!/usr/bin/env python3
"""Part of accuracy.sh.

accuracy.py known FOLDER ROOT: renews src/aim/measured.csv from the sweeps in FOLDER.
accuracy.py tables FOLDER ROOT: renews the tables of docs/accuracy.md from what FOLDER holds."""
import csv
import math
import pathlib
import sys

BEGIN, END = "<!-- made by docs/accuracy.sh -->", "<!-- end -->"
NUMBERS = ("seconds", "processor_seconds", "error", "luxels", "expected_seconds", "expected_error", "half_seconds")


def points(path):
    rows = list(csv.DictReader(path.open()))
    for row in rows:
        row.update((name, float(row[name])) for name in NUMBERS)
        row["knobs"] = dict(pair.split("=") for pair in row["settings"].split())
    # Other programs change processor seconds little; they are told in hundredths.
    all_told = all(row["processor_seconds"] >= 0.2 for row in rows)
    for row in rows:
        row["time"] = row["processor_seconds" if all_told else "seconds"]
    return rows


def sweeps(folder, against="truth"):
    """Sweeps by name: against known light, or against their own finest settings."""
    found = {p.parent.name: points(p) for p in sorted(folder.glob("sweeps/*/sweep.csv"))}
    return {name: rows for name, rows in found.items() if rows[-1]["against"] == against}


def known(folder, root):
    path = root / "src/aim/measured.csv"
    rows = list(csv.DictReader(path.open()))
    names = ["hemicube", "patch", "gather", "share"]
    rungs = list(dict.fromkeys(tuple(row[n] for n in names) for row in rows))
    renewed = 0
    for name, swept in sweeps(folder).items():
        found = {tuple(r["knobs"][n] for n in names): r for r in swept
                 if r["knobs"].get("samples") == "1" and r["knobs"]["bounces"] == "all"}
        if all(rung in found for rung in rungs):
            renewed += 1
            rows = [row for row in rows if row["map"] != name]
            rows += [dict(zip(names, rung), map=name, error=f"{found[rung]['error']:.4f}",
                          luxels=f"{found[rung]['luxels']:.3f}") for rung in rungs]
    if renewed == 0:
        sys.exit(f"no sweep of a map has all settings of {path}")
    with path.open("w", newline="") as file:
        out = csv.DictWriter(file, ["map", *names, "error", "luxels"], lineterminator="\n")
        out.writeheader()
        out.writerows(rows)


def exponent(line):
    logs = [(math.log(r["time"]), math.log(r["error"])) for r in line if r["error"] > 0]
    if len(logs) < 2:
        return None
    mx, my = (sum(v) / len(logs) for v in zip(*logs))
    xx = sum((x - mx) ** 2 for x, _ in logs)
    return -sum((x - mx) * (y - my) for x, y in logs) / xx if xx / len(logs) > 0.01 else None


def presets(found):
    yield "| sweep | preset | rms | s | least s for that rms | least rms in those s |"
    yield "|---|---|---|---|---|---|"
    for name, rows in found.items():
        for row in rows:
            if row["preset"] and row["error"] > 0:
                quick = min(r["time"] for r in rows if r["error"] <= row["error"] * 1.0001)
                good = min(r["error"] for r in rows if r["time"] <= row["time"] * 1.0001)
                yield (f"| {name} | {row['preset']} | {row['error']:.2%} | {row['time']:.2f} "
                       f"| {quick:.2f} | {good:.2%} |")


def settings(found):
    yield "| sweep | setting | p | values: rms in s |"
    yield "|---|---|---|---|"
    for name, rows in found.items():
        normal = next((r for r in rows if r["preset"] == "normal"), None)
        for knob in normal["knobs"] if normal else []:
            same = [r for r in rows if all(r["knobs"][k] == v for k, v in normal["knobs"].items() if k != knob)]
            if len(same) > 1:
                p = exponent(same)
                values = "; ".join(f"{r['knobs'][knob]}: {r['error']:.2%} in {r['time']:.2f}" for r in same)
                yield f"| {name} | {knob} | {'-' if p is None else f'{p:.2f}'} | {values} |"


def halves(found):
    yield "| sweep | preset | rms | s | half the rms, told: s | taken | rms then |"
    yield "|---|---|---|---|---|---|---|"
    for name, rows in found.items():
        at = {r["settings"]: r for r in rows}
        for row in rows:
            there = at.get(row["half_settings"])
            if row["half_seconds"] and there:
                # The run told seconds of a clock.
                told = row["half_seconds"] * row["time"] / row["seconds"]
                yield (f"| {name} | {row['preset']} | {row['error']:.2%} | {row['time']:.2f} "
                       f"| {told:.2f} | {there['time']:.2f} | {there['error']:.2%} |")


def asked(folder):
    all_rows = [(p.parent.name.rsplit("-", 1)[0], r) for p in sorted(folder.glob("asked/*/sweep.csv"))
                for r in points(p)]
    all_rows.sort(key=lambda x: (x[0], -float(x[1]["knobs"]["target"])))
    target = lambda r: float(r["knobs"]["target"])
    ratio = lambda r: r["seconds"] / r["expected_seconds"]
    # Below a tenth of a second it is the machine that is measured.
    timed = [x for x in all_rows if x[1]["seconds"] >= 0.1]
    far = [x for x in all_rows if x[1]["error"] > 1.5 * target(x[1])]
    late = [x for x in timed if not 1 / 1.5 <= ratio(x[1]) <= 1.5]
    if not all_rows:
        return
    yield (f"{len(all_rows)} runs: the error is at most 1.5 times the target in {len(all_rows) - len(far)} "
           f"({1 - len(far) / len(all_rows):.0%}); the time within a factor of 1.5 of what was predicted in "
           f"{len(timed) - len(late)} of the {len(timed)} that took 0.1 s or more "
           f"({1 - len(late) / max(len(timed), 1):.0%}). Misses are in bold.")
    yield ""
    yield "| scene or map | target | predicted rms | true rms | predicted s | taken s |"
    yield "|---|---|---|---|---|---|"
    bold = lambda text, miss: f"**{text}**" if miss else text
    for x in all_rows:
        name, r = x
        yield (f"| {name} | {target(r):.1%} | {r['expected_error']:.2%} | {bold(format(r['error'], '.2%'), x in far)} "
               f"| {r['expected_seconds']:.2f} | {bold(format(r['seconds'], '.2f'), x in late)} |")


def tables(folder, root):
    found = sweeps(folder)
    made = {"presets": presets(found), "demo": presets(sweeps(folder, "finest")),
            "settings": settings(found), "halves": halves(found),
            "asked": asked(folder)}
    path = root / "docs/accuracy.md"
    text = path.read_text()
    for name, lines in made.items():
        begin = BEGIN.replace("made", f"{name}: made")
        before, rest = text.split(begin, 1)
        after = rest.split(END, 1)[1]
        text = before + begin + "\n" + "\n".join(lines) + "\n" + END + after
    path.write_text(text)


if __name__ == "__main__":
    {"known": known, "tables": tables}[sys.argv[1]](*map(pathlib.Path, sys.argv[2:4]))
