#!/usr/bin/python3
"""Holds the memory that `noiseloom plan` forecasts against the peaks of real runs.

    tests/bench/plan_memory.py [--bin FOLDER] [--only WORD]... [--resume]

Every config is run with `generate` until its first save (--time-limit 1s), by itself or under mpirun; the peak is the
largest resident set of any rank, from its start to its end. With --resume the run is also taken up again from that
save, which may need more. Prints both figures and their ratio, and exits with 1 where a ratio lies outside 1/1.2 to 1.2.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy

GAUSS = '{ axes = "xy", kernel = "gauss", sigma = 1.0 }'
EMA = '{ axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 }'


# Long enough that a visit makes many swaps; with features, short enough to come to the end, which has the most of them.
def swaps(size, samples, *groups, combine="product", method="anneal", iterations=None, extra=""):
    iterations = iterations or (48 if EMA in groups and combine == "product" else 2000)
    stop = "" if method == "construct" else f"stop = {{ iterations = {iterations} }}"
    return f"""
[texture]
size    = {{ {size} }}
samples = {samples}
[filter]
combine = "{combine}"
groups  = [ {", ".join(groups or (GAUSS,))} ]
[optimizer]
method = "{method}"
{stop}
{extra}"""


def order(size, *groups, extra=""):
    return f"""
[texture]
size    = {{ {size} }}
[filter]
combine = "sum"
groups  = [ {", ".join(groups)} ]
[optimizer]
method = "void-and-cluster"
{extra}"""


def blue(axes, sigma=1.9):
    return f'{{ axes = "{axes}", kernel = "gauss-energy", sigma = {sigma} }}'


# name: config, ranks, threads
CASES = {
    "smallest": (swaps("x = 2, y = 2", '"uniform"', '{ axes = "xy", kernel = "box", size = 2 }'), 1, 1),
    "smallest, 8 threads": (swaps("x = 2, y = 2", '"uniform"', '{ axes = "xy", kernel = "box", size = 2 }'), 1, 8),
    "smallest, 2 ranks": (swaps("x = 2, y = 2", '"uniform"', '{ axes = "xy", kernel = "box", size = 2 }'), 2, 1),
    "smallest, 4 ranks": (swaps("x = 2, y = 2", '"uniform"', '{ axes = "xy", kernel = "box", size = 2 }'), 4, 1),
    "scalar plane": (swaps("x = 2048, y = 2048", '"uniform"'), 1, 1),
    "scalar plane, 4 threads": (swaps("x = 2048, y = 2048", '"uniform"'), 1, 4),
    "scalar slices": (swaps("x = 128, y = 128, t = 64", '"uniform"'), 1, 2),
    "scalar product": (swaps("x = 128, y = 128, t = 256", '"uniform"', GAUSS, EMA), 1, 2),
    "scalar product, 2 ranks": (swaps("x = 128, y = 128, t = 256", '"uniform"', GAUSS, EMA), 2, 1),
    "scalar product, 4 ranks": (swaps("x = 128, y = 128, t = 256", '"uniform"', GAUSS, EMA), 4, 1),
    "deep product": (swaps("x = 16, y = 16, t = 20000", '"uniform"', GAUSS, EMA), 1, 1),
    "tent": (swaps("x = 1024, y = 1024", '"tent"'), 1, 1),
    "sum": (swaps("x = 128, y = 128, t = 128", '"uniform"', GAUSS, EMA, combine="sum"), 1, 2),
    "vector2 slices": (swaps("x = 128, y = 128, t = 64", '"vector2"', GAUSS), 1, 2),
    "vector2 product": (swaps("x = 128, y = 128, t = 64", '"vector2"', GAUSS, EMA), 1, 2),
    "vector4 plane": (swaps("x = 1024, y = 1024", '"vector4"'), 1, 2),
    "vector8 plane": (swaps("x = 1024, y = 1024", '"vector8"'), 1, 1),
    "sphere plane": (swaps("x = 2048, y = 2048", '"sphere"', '{ axes = "xy", kernel = "box", size = 3 }'), 1, 2),
    "hemisphere-cosine slices": (swaps("x = 64, y = 64, t = 64", '"hemisphere-cosine"', GAUSS), 1, 1),
    "hemisphere-cosine plane": (swaps("x = 1024, y = 1024", '"hemisphere-cosine"', GAUSS), 1, 2),
    "list": (swaps("x = 1024, y = 1024, t = 4", '{ file = "one.npy" }'), 1, 1),
    "lists": (swaps("x = 512, y = 512, t = 16", '{ file = "lists.npy" }'), 1, 1),
    "lists, 2 ranks": (swaps("x = 512, y = 512, t = 16", '{ file = "lists.npy" }'), 2, 1),
    "fast": (swaps("x = 1024, y = 1024", '"uniform"', method="fast"), 1, 2),
    "wide gauss": (swaps("x = 512, y = 512", '"uniform"', '{ axes = "xy", kernel = "gauss", sigma = 40 }'), 1, 1),
    "wide energy": (swaps("x = 1024, y = 1024", '"uniform"', blue("xy", 60)), 1, 1),
    "construct plane": (swaps("x = 2048, y = 2048", '"uniform"', method="construct"), 1, 1),
    "construct product": (swaps("x = 128, y = 128, t = 256", '"uniform"', GAUSS, EMA, method="construct"), 1, 2),
    "construct product, 4 ranks": (swaps("x = 128, y = 128, t = 256", '"uniform"', GAUSS, EMA, method="construct"), 4, 1),
    "construct tent": (swaps("x = 1024, y = 1024", '"tent"', method="construct"), 1, 1),
    "construct sum": (swaps("x = 128, y = 128, t = 128", '"uniform"', GAUSS, EMA, combine="sum", method="construct"), 1, 1),
    "order plane": (order("x = 2048, y = 2048", blue("xy")), 1, 1),
    "order plane, 4 threads": (order("x = 2048, y = 2048", blue("xy")), 1, 4),
    "order slices": (order("x = 128, y = 128, t = 128", blue("xy"), blue("t")), 1, 2),
    "order slices, 4 ranks": (order("x = 128, y = 128, t = 128", blue("xy"), blue("t")), 4, 1),
    "order 2Dx2D": (order("x = 64, y = 64, z = 24, w = 24", blue("xy"), blue("zw")), 1, 1),
    **{f"order large, {ranks} ranks": (order("x = 256, y = 256, t = 128", blue("xy"), blue("t")), ranks, 1) for ranks in (1, 2, 4)},
    **{f"order 2Dx2D large, {ranks} ranks": (order("x = 64, y = 64, z = 32, w = 32", blue("xy"), blue("zw")), ranks, 1) for ranks in (1, 2, 4)},
    **{f"construct large, {ranks} ranks": (swaps("x = 256, y = 256, t = 64", '"uniform"', GAUSS, EMA, method="construct"), ranks, 1)
       for ranks in (1, 2, 4)},
    **{f"vector2 large, {ranks} ranks": (swaps("x = 256, y = 256, t = 64", '"vector2"', GAUSS, EMA), ranks, 1) for ranks in (1, 2, 4)},
    "order wide": (order("x = 512, y = 512", blue("xy", 60)), 1, 1),
}

# Runs the command that follows and writes the largest resident set that it had, in KiB.
WRAPPER = """
import os, sys
child = os.fork()
if child == 0:
    os.execv(sys.argv[2], sys.argv[2:])
_, status, usage = os.wait4(child, 0)
rank = os.environ.get("OMPI_COMM_WORLD_RANK", "0")
open(f"{sys.argv[1]}.{rank}", "w").write(str(usage.ru_maxrss))
sys.exit(os.waitstatus_to_exitcode(status))
"""

MPI = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
       "OMPI_MCA_hwloc_base_binding_policy": "none", "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}


def write_inputs(folder):
    random = numpy.random.default_rng(1)
    numpy.save(folder / "one.npy", random.random((1024 * 1024, 2)).astype("f4"))
    numpy.save(folder / "lists.npy", random.random((16, 512 * 512)).astype("f4"))


def peak_mib(program, folder, ranks, threads, *options):
    """The largest peak of any rank, MiB."""
    for old in folder.glob("peak.*"):
        old.unlink()
    command = [sys.executable, "-c", WRAPPER, str(folder / "peak"), str(program), "generate", "run.toml", "-o", "run.h5",
               "--threads", str(threads), "--progress", "none", *options]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks)] + command
    done = subprocess.run(command, cwd=folder, env={**os.environ, **MPI}, capture_output=True, text=True)
    if not list(folder.glob("peak.*")):
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    if done.returncode not in (0, 75):
        print(done.stderr, file=sys.stderr)
    return max(int(path.read_text()) for path in folder.glob("peak.*")) / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    source = pathlib.Path(__file__).resolve().parents[2]
    parser.add_argument("--bin", type=pathlib.Path, default=source / ".build/release/bin", help="folder of noiseloom")
    parser.add_argument("--only", action="append", default=[], help="configs whose name has this word")
    parser.add_argument("--resume", action="store_true", help="measure taking a run up again too")
    arguments = parser.parse_args()
    program = arguments.bin.resolve() / "noiseloom"
    failures = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_inputs(folder)
        print(f"{'':<28} {'planned':>8} {'peak':>8} {'resumed':>8}   planned / peak   MiB")
        for case, (config, ranks, threads) in CASES.items():
            if arguments.only and not any(word in case for word in arguments.only):
                continue
            (folder / "run.toml").write_text(config)
            (folder / "run.h5").unlink(missing_ok=True)
            (folder / "run.h5.prev").unlink(missing_ok=True)
            planned = subprocess.run(
                [program, "plan", "run.toml", "--ranks", str(ranks), "--threads", str(threads), "--json"], cwd=folder,
                capture_output=True, text=True)
            figures = json.loads(planned.stdout) if planned.returncode == 0 else {}
            planned_mib = figures.get("memory", {}).get("rank_bytes", 0) / 2**20
            # Construction scores at its end.
            limit = () if "iterations = 48" in config or '"construct"' in config else ("--time-limit", "1s")
            peak = peak_mib(program, folder, ranks, threads, *limit)
            resumed = peak_mib(program, folder, ranks, threads, "--resume", *limit) if arguments.resume else 0
            ratio = planned_mib / max(peak, resumed)
            wrong = not 1 / 1.2 <= ratio <= 1.2
            failures += wrong
            parts = {key: round(value / 2**20, 1) for key, value in figures.get("memory", {}).get("parts", {}).items()}
            print(f"{case:<28} {planned_mib:8.1f} {peak:8.1f} {resumed:8.1f}   {ratio:.2f}{'  WRONG' if wrong else ''}   {parts}",
                  flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
