#!/usr/bin/python3
"""How good are the textures that a build makes in a given time? Generates each, exports it to 8 bits, scores the image
with independent_score.py and prints a Markdown table. Also in OUT: table.md, table.json (rows found there are not made
again) and the images.

    quality_table.py .build/release/bin -o quality --seconds 30
    quality_table.py .build/release/bin -o quality --seconds 5 --only 'circle.*box 5' --fast-iterations 10000

With --fast-iterations, textures without a published figure are made by the paper's own method too, and compared with that.
"""

import argparse
import concurrent.futures
import dataclasses
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time

import independent_score


@dataclasses.dataclass(frozen=True)
class Row:
    samples: str
    groups: tuple  # (axes, kernel, numbers)
    combine: str = "product"
    slices: int = 1
    published: float = None
    target: float = None  # what prototypes reached

    @property
    def name(self):
        filters = [" ".join([kernel, *(f"{number:g}" for number in numbers)]) for _, kernel, numbers in self.groups]
        joined = (" x " if self.combine == "product" else " + ").join(filters)
        return f"{self.samples} 128x128x{self.slices} {joined}"

    @property
    def space(self):
        words = {"uniform": "scalar", "tent": "scalar", "hemisphere": "sphere", "hemisphere-cosine": "sphere"}
        return words.get(self.samples, self.samples)

    def config(self):
        keys = {"box": ["size"], "binomial": ["n"], "gauss": ["sigma"], "ema": ["alpha", "rejection"]}
        groups = []
        for axes, kernel, numbers in self.groups:
            settings = ", ".join(f"{key} = {number}" for key, number in zip(keys[kernel], numbers))
            groups.append(f'{{ axes = "{axes}", kernel = "{kernel}", {settings} }}')
        depth = f", t = {self.slices}" if self.slices > 1 else ""
        return (f'[texture]\nsize = {{ x = 128, y = 128{depth} }}\nsamples = "{self.samples}"\n'
                f'[filter]\ncombine = "{self.combine}"\ngroups = [ {", ".join(groups)} ]\n')


EMA = ("t", "ema", (0.1, 0.1))
SPATIAL = [("xy", "box", (3,)), ("xy", "box", (5,)), ("xy", "binomial", (2,)), ("xy", "binomial", (3,)),
           ("xy", "gauss", (0.7,)), ("xy", "gauss", (1.0,))]
KNOWN = {("vector2", "gauss", 1.0): (0.2263, None), ("hemisphere-cosine", "box", 5): (0.3150, 0.221)}


def all_rows():
    rows = [Row("uniform", (SPATIAL[0],), published=0.1868, target=0.142),
            Row("uniform", (SPATIAL[1],), published=0.1110, target=0.088),
            Row("uniform", (SPATIAL[5],), published=0.1221, target=0.104)]
    for samples in ["tent", "circle", "vector2", "vector3", "vector4", "sphere", "hemisphere-cosine"]:
        for group in SPATIAL:
            published, target = KNOWN.get((samples, group[1], group[2][0]), (None, None))
            rows.append(Row(samples, (group,), published=published, target=target))
    rows.append(Row("uniform", (("xy", "gauss", (1.3435,)), EMA), slices=64, published=0.0840, target=0.0602))
    rows.append(Row("uniform", (("xy", "gauss", (1.0,)), EMA), combine="sum", slices=32, published=0.7791))
    rows.append(Row("hemisphere-cosine", (SPATIAL[1], EMA), slices=32))
    return rows


def make(row, stop, method, given, image):
    """Generates and exports one texture: R of the image, wall seconds of the run, iterations."""
    program = given.bin_dir / "noiseloom"
    with tempfile.TemporaryDirectory(prefix="noiseloom-quality-") as folder:
        config = pathlib.Path(folder) / "config.toml"
        run = pathlib.Path(folder) / "run.h5"
        config.write_text(row.config())
        command = [program, "generate", config, "-o", run, "--progress", "none", "--set", f"optimizer.stop={stop}",
                   "--set", f"optimizer.method={method}", "--threads", str(given.threads)]
        began = time.monotonic()
        finished_program(command)
        seconds = time.monotonic() - began
        finished_program([program, "export", run, "-o", image, "--layout", "strip", "--depth", "8", "--overwrite"])
        history = json.loads(finished_program([program, "info", run, "--json"]))["history"]
    r = independent_score.score_images([image], row.space, row.groups, row.combine, row.slices)
    return {"relative_error": r, "seconds": seconds, "iterations": history["iterations"][-1],
            "own_relative_error": history["relative_error"][-1]}


def finished_program(command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}: exit {done.returncode}\n{done.stderr}")
    return done.stdout


def measure(row, given, results, lock):
    found = results.get(row.name, {})
    todo = {}
    if found.get("asked_seconds") != given.seconds:
        todo["ours"] = (f'{{time="{given.seconds}s"}}', "anneal")
    if given.fast_iterations and row.published is None and found.get("fast_iterations") != given.fast_iterations:
        todo["fast"] = (f"{{iterations={given.fast_iterations}}}", "fast")
    for key, (stop, method) in todo.items():
        image = given.output / f"{re.sub('[^a-z0-9.]+', '_', row.name)}_{key}.png"
        made = make(row, stop, method, given, image)
        with lock:
            entry = results.setdefault(row.name, {})
            entry[key] = made
            entry["asked_seconds" if key == "ours" else "fast_iterations"] = (
                given.seconds if key == "ours" else given.fast_iterations)
            partial = given.output / "table.json.part"
            partial.write_text(json.dumps(results, indent=1))
            os.replace(partial, given.output / "table.json")
            print(f"{row.name}: {key} R = {made['relative_error']:.4f} in {made['seconds']:.1f} s", file=sys.stderr)


def reference_of(row, entry):
    return row.published if row.published is not None else entry.get("fast", {}).get("relative_error")


def table(rows, results):
    def number(value, digits=4):
        return "-" if value is None else f"{value:.{digits}f}"

    lines = ["| texture | published R | the paper's method R (s) | target | R | ratio | seconds |",
             "|---|---|---|---|---|---|---|"]
    ratios = {}
    for row in rows:
        entry = results.get(row.name, {})
        if "ours" not in entry:
            continue
        r = entry["ours"]["relative_error"]
        reference = reference_of(row, entry)
        if reference is not None:
            ratios[row] = r / reference
        fast = entry.get("fast")
        fast_text = "-" if fast is None else f"{fast['relative_error']:.4f} ({fast['seconds']:.1f})"
        lines.append(f"| {row.name} | {number(row.published)} | {fast_text} | {number(row.target)} | {number(r)} | "
                     f"{number(ratios.get(row), 3)} | {number(entry['ours']['seconds'], 1)} |")
    for words, some in [("all", ratios), ("single slices that are not scalars",
                                          {row: x for row, x in ratios.items() if row.slices == 1 and row.samples != "uniform"})]:
        if some:
            mean = math.exp(sum(map(math.log, some.values())) / len(some))
            lines.append(f"\nGeometric mean of {len(some)} ratios ({words}): {mean:.3f}")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path, help="holds noiseloom and noiseloom-study")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder, made if missing")
    parser.add_argument("--seconds", type=float, default=30, help="optimizer.stop.time of each texture")
    parser.add_argument("--only", default="", metavar="REGEX", help="textures whose name it matches (--list)")
    parser.add_argument("--jobs", type=int, default=1, help="textures at once")
    parser.add_argument("--threads", type=int, help="of each run (default: processors / jobs)")
    parser.add_argument("--fast-iterations", type=int, default=0, help="of the paper's method; 0: leave it out")
    parser.add_argument("--list", action="store_true", help="print the names of the textures")
    given = parser.parse_args()
    given.threads = given.threads or max(1, len(os.sched_getaffinity(0)) // given.jobs)
    rows = [row for row in all_rows() if re.search(given.only, row.name)]
    if given.list:
        print("\n".join(row.name for row in rows))
        return
    given.output.mkdir(parents=True, exist_ok=True)
    stored = given.output / "table.json"
    results = json.loads(stored.read_text()) if stored.exists() else {}
    lock = threading.Lock()
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        try:
            for _ in pool.map(lambda row: measure(row, given, results, lock), rows):
                pass
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    text = table(all_rows(), results)
    (given.output / "table.md").write_text(text)
    print(text, end="")


if __name__ == "__main__":
    main()
