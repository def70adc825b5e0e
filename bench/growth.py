#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes docs/results/growth.md: what a map costs as it grows, and what it finds.

Towns of 1 km of streets, each another one, are put side by side in one frame; frames are 4 m apart. CPU time (user and system) and
peak memory are those of one process with one thread. `--before PROGRAM` measures another program in turn and prints its rows only.
"""
import argparse
import datetime
import json
import math
import multiprocessing
import os
import random
import shutil
import struct
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table, wrapped
from results import with_interval

ROOT = Path(__file__).resolve().parent.parent
STYLES = ("suburb", "grid", "suburb", "village", "suburb")
SIDE_M, PER_ROW, WINDOW, WINDOWS = 1600, 4, 15, 4  # of a town, towns, frames of a query, queries of a town
NEW = [(i, i + 62) for i in range(0, 248, 62)]  # frames of a second drive: 250 m each
STRANGER_SEED, SEED = 1990, 900  # towns have the seeds behind
KINDS = (71, 80, 81)  # of semantic_kitti: trunk, pole, traffic sign
BLOCK_M, DISC_M, DISCS = 80, 100, 20

Cost = namedtuple("Cost", "cpu_s peak_mb text")


def run(program, *arguments, may_fail=False):
    read, write = os.pipe()
    pid = os.posix_spawn(program, [program, *map(str, arguments)], os.environ,
                         file_actions=[(os.POSIX_SPAWN_DUP2, write, 1), (os.POSIX_SPAWN_CLOSE, read)])
    os.close(write)
    with os.fdopen(read) as answers:
        text = answers.read()
    _, status, usage = os.wait4(pid, 0)
    if status != 0 and not may_fail:
        sys.exit(f"{program} {' '.join(map(str, arguments))}: ended with status {status}")
    return Cost(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, text)


def shifted(path, number):
    x, y = SIDE_M * (number % PER_ROW), SIDE_M * (number // PER_ROW)
    lines = [line.split() for line in path.read_text().splitlines()]
    path.write_text("".join(f"{t} {float(px) + x!r} {float(py) + y!r} {' '.join(rest)}\n" for t, px, py, *rest in lines))


def town(program, folder, seed, number):
    """A drive, the same looking back, and one a little beside on another day; all in the frame of the map."""
    if (folder / "done").exists():
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    run(program, "simulate", folder, "--seed", seed, "--sim.style", STYLES[number % len(STYLES)], "--route_length_m", 1000,
        "--frame_spacing_m", 4, "--sessions.forward2", "--sessions.aerial=false", "-q")
    for session in ("forward", "rear", "forward2"):
        for name in ("poses.txt", "groundtruth.txt"):
            if session == "rear" and name == "poses.txt":
                continue  # what odometry says
            truth = folder / session / "groundtruth.txt"
            if name == "poses.txt":
                shutil.copy(truth, folder / session / name)
        shifted(folder / session / "groundtruth.txt", number)
        if session != "rear":
            shifted(folder / session / "poses.txt", number)
    (folder / "done").touch()
    return folder


def answers(cost):
    return [json.loads(line) for line in cost.text.splitlines() if line.startswith("{")]


def is_right(answer, truth):
    there = truth[answer["query"]["last_index"]]
    return sum((p - t) ** 2 for p, t in zip(answer["pose"]["position"], there)) ** 0.5 <= 5


def accuracy(program, towns, stranger, map_path):
    """Right, accepted and wrong of the windows of all towns; strangers and those accepted."""
    right = accepted = wrong = asked = 0
    for folder in towns:
        truth = [[float(v) for v in line.split()[1:4]] for line in (folder / "rear/groundtruth.txt").read_text().splitlines()]
        stride = len(truth) // WINDOWS
        for a in answers(run(program, "localize", folder / "rear", map_path, "--window", WINDOW, "--stride", stride, "--json", "-q",
                             may_fail=True))[:WINDOWS]:
            good = bool(a.get("pose")) and is_right(a, truth)
            asked, right = asked + 1, right + good
            accepted += good and a["status"] == "accepted"
            wrong += not good and a["status"] == "accepted"
    others = answers(run(program, "localize", stranger / "rear", map_path, "--window", WINDOW, "--json", "-q", may_fail=True))
    return asked, right, accepted, wrong, len(others), sum(a["status"] == "accepted" for a in others)


def things(count):
    """(x, y, kind) of things along the streets of a grid of blocks, in rows of one kind that begin and end anywhere."""
    draw = random.Random(1)
    side = max(2, round(math.sqrt(count / 40)))
    for block in range(side * side):
        for along in (False, True):
            for beside in (-6, 6):
                kind, at = draw.choice(KINDS), draw.uniform(0, 8)
                while at < BLOCK_M:
                    kind = draw.choice(KINDS) if draw.random() < 0.12 else kind
                    u, v = at + draw.gauss(0, 0.8), beside + draw.gauss(0, 0.8)
                    if draw.random() < 0.85:
                        yield block // side * BLOCK_M + (u if along else v), block % side * BLOCK_M + (v if along else u), kind
                    at += draw.uniform(5, 11)


def write_graph(path, items):
    data, count = bytearray(), 0
    for x, y, kind in items:
        data += struct.pack("<dddiI", x, y, 0, kind, 1)
        count += 1
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex " + str(count) + "\nproperty double x\nproperty double y\n"
              "property double z\nproperty int label\nproperty uint observations\nend_header\n")
    path.write_bytes(header.encode() + data)
    return count


def discs_of(count):
    """Discs around anywhere: (middle, things in a frame of their own), 70 % of the things seen with an error of 0.5 m."""
    draw = random.Random(3)
    side_m = max(2, round(math.sqrt(count / 40))) * BLOCK_M
    discs = [((draw.uniform(0.1, 0.9) * side_m, draw.uniform(0.1, 0.9) * side_m), draw.uniform(0, 2 * math.pi), []) for _ in range(DISCS)]
    for x, y, kind in things(count):
        for (mx, my), yaw, seen in discs:
            if (x - mx) ** 2 + (y - my) ** 2 <= DISC_M ** 2 and draw.random() < 0.7:
                dx, dy = x - mx + draw.gauss(0, 0.5), y - my + draw.gauss(0, 0.5)
                seen.append((math.cos(yaw) * dx + math.sin(yaw) * dy, math.cos(yaw) * dy - math.sin(yaw) * dx, kind))
    return [(middle, seen) for middle, _, seen in discs]


def write_things(count, folder):
    """Number of things, and middle and path of each disc. In a process of its own: peak memory of a command includes that of who starts it."""
    there = write_graph(folder / f"things_{count}.ply", things(count))
    discs = []
    for number, (middle, seen) in enumerate(discs_of(count)):
        discs.append((middle, folder / f"disc_{count}_{number}.ply"))
        write_graph(discs[-1][1], seen)
    return there, discs


def measure_things(programs, counts, folder):
    rows = []
    for count in counts:
        with multiprocessing.get_context("spawn").Pool(1) as writer:
            there, discs = writer.apply(write_things, (count, folder))
        graph, map_path = folder / f"things_{count}.ply", folder / f"things_{count}.xvm"
        paths = [path for _, path in discs]
        for which, program in enumerate(programs):
            flags = ("--labels", "semantic_kitti", "--threads", 1, "-q")
            map_path.unlink(missing_ok=True)
            made = run(program, "map", graph, map_path, *flags)
            cold = [run(program, "localize", paths[0], map_path, *flags, may_fail=True) for _ in range(3)]
            all_of_them = run(program, "localize", *paths, map_path, *flags, "--json", may_fail=True)
            right = accepted = wrong = 0
            for (middle, _), a in zip(discs, answers(all_of_them)):
                T = a.get("T_map_query")
                good = bool(T) and math.dist((T[3], T[7]), middle) <= 5
                right, accepted = right + good, accepted + (good and a["status"] == "accepted")
                wrong += not good and a["status"] == "accepted"
            first = sorted(c.cpu_s for c in cold)[1]
            rows.append([f"{there:,}" + (", before" if which else ""), f"{made.cpu_s:.1f}", f"{made.peak_mb:.0f}", f"{map_path.stat().st_size / 1e6:.1f}",
                         f"{first:.2f}", f"{max(c.peak_mb for c in cold):.0f}", f"{max(0, all_of_them.cpu_s - first) / (DISCS - 1):.2f}",
                         f"{right}, {accepted} of {DISCS}", str(wrong)])
            print(rows[-1], file=sys.stderr)
        graph.unlink()
    return rows


def of_use(program, town, name, folder):
    """CPU time and peak memory of a first answer, of appending and of fusing 250 m."""
    cold = [run(program, "localize", town / "rear", name, "--frames", "100:115", "--threads", 1, "-q") for _ in range(3)]
    cells = [f"{sorted(c.cpu_s for c in cold)[1]:.2f}", f"{max(c.peak_mb for c in cold):.0f}"]
    for command in (("map", "--append", town / "forward2"), ("fuse", town / "rear")):
        grown = folder / "grown.xvm"
        shutil.copy(name, grown)
        added = [run(program, *command, grown, "--frames", f"{first}:{last}", "--threads", 1, "-q") for first, last in NEW]
        cells += [f"{sum(a.cpu_s for a in added) / len(added):.2f}", f"{max(a.peak_mb for a in added):.0f}"]
    return cells


def measure(programs, kilometres, folder):
    towns = [town(programs[0], folder / f"town{i}", SEED + i, i) for i in range(max(kilometres))]
    stranger = town(programs[0], folder / "stranger", STRANGER_SEED, 0)
    costs, finds = [], []
    for km in kilometres:
        for which, program in enumerate(programs):
            name = folder / f"{km}_{which}.xvm"
            name.unlink(missing_ok=True)
            made = run(program, "map", *(t / "forward" for t in towns[:km]), name, "--threads", 1, "-q")
            size_mb = name.stat().st_size / 1e6
            row = [str(km) + (", before" if which else ""), f"{made.cpu_s:.1f}", f"{made.peak_mb:.0f}", f"{size_mb / km:.2f}",
                   *of_use(program, towns[0], name, folder)]
            print(row, file=sys.stderr)
            if which == 0:
                costs.append(row)
                asked, right, accepted, wrong, strangers, taken = accuracy(program, towns[:km], stranger, name)
                finds.append([str(km), str(asked), with_interval(right, asked), with_interval(accepted, right), str(wrong),
                              f"{taken} of {strangers}"])
                print(finds[-1], file=sys.stderr)
    return costs, finds


def page(costs, finds, of_things):
    return f"""# What a map costs as it grows

Written by `./run growth` on {datetime.date.today()}; do not edit. {__doc__.split(chr(10) * 2)[1].strip().split(" `--before")[0]}

{table([["km", "making it, CPU s", "MB", "file, MB per km", "first answer, CPU s", "MB", "250 m appended, CPU s", "MB", "250 m fused, CPU s",
         "MB"], *costs])}

*First answer*: a process that opens the map and answers one query of 15 frames, median of three. *250 m appended*: `xview map --append` of
62 frames along streets that the map has, mean of four one after the other; now and then one of them asks for a stretch of the map in the whole map.
*250 m fused*: `xview fuse` of the same with the drive back, which is looked for first.

## What is found in it

{table([["km", "queries", "right, %", "of these accepted, %", "wrong accepted", "out-of-map queries accepted"], *finds])}

Queries look back where the map looked ahead, 15 frames (56 m) each; out-of-map queries are all windows of a town that is in no map.

## Bare graphs

{table([["things", "making the map, CPU s", "MB", "file, MB", "first answer, CPU s", "MB", "each of 19 more, CPU s", "right, accepted",
         "wrong accepted"], *of_things])}

Things of three kinds stand in rows along the streets of a grid of blocks of {BLOCK_M} m. A query is a disc of {DISC_M} m: 70 % of the things, 0.5 m off.
"""


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--km", default="1,3,10", help="lengths of the maps, separated by commas")
    arguments.add_argument("--things", default="10000,100000,1000000", help="sizes of bare graphs, separated by commas")
    arguments.add_argument("--before", action="append", default=[], help="another program, to compare costs")
    arguments.add_argument("--program", default=str(ROOT / "build/xview"))
    arguments.add_argument("--work", default="build/growth", help="folder for towns and maps")
    given = arguments.parse_args()
    folder = Path(given.work)
    folder.mkdir(parents=True, exist_ok=True)
    programs = [given.program, *given.before]
    of_things = measure_things(programs, [int(n) for n in given.things.split(",")], folder)
    costs, finds = measure(programs, [int(k) for k in given.km.split(",")], folder)
    if not given.before:
        (ROOT / "docs/results/growth.md").write_text(wrapped(page(costs, finds, of_things)))


if __name__ == "__main__":
    main()
