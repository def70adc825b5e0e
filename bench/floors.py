#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Buildings of several floors: is a window found on its own floor, or told to be ambiguous?

    bench/floors.py [--program build/xview] [--floors 4] [--seeds 5201,5301] [--kinds other,mould,same]
                    [--work FOLDER] [--raw] [--cloud]

Three kinds of buildings are made of simulated offices, one above the other at 3.2 m: `same` floors that are one
another's copies, floors of one `mould`, where more and more of the furniture stands elsewhere, and `other` floors. Windows of a
second walk on each floor, with a camera that looks back, usual labels (83 % of the pixels right; --raw: none) and an
odometry of its own, are localized in the map of the building, or (--cloud) in one cloud of it that knows no poses.
Prints a row per kind; exit code 1 if a window is accepted more than half a metre from where it is.
"""
import argparse
import json
import math
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table

ROOT = Path(__file__).resolve().parent.parent
HEIGHT_M, RIGHT_M = 3.2, 0.5
WINDOWS = (15, 40)  # frames


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(done.stderr)
    return done.stdout


def poses(path):
    return [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]


def floor_of(program, work, kind, seed, number, floors):
    """The folder of a floor, its mapping drive with poses in the frame of the building, and the way there."""
    changed = number / max(1, floors - 1) if kind == "mould" else 0
    drive = "forward2" if changed else "forward"
    folder = work / f"{kind}_{seed}_{number}of{floors}"
    if not folder.exists():
        run(program, "simulate", folder, "--seed", seed + (number if kind == "other" else 0), "--sim.style", "office",
            "--sessions.aerial=false", "--sessions.forward2=true", "--sim.changed", changed, "--quality", "noisy",
            "--label_noise.accuracy", "0.83", "--drift", "0.01", "-q")
    rows = poses(folder / drive / "groundtruth.txt")
    middle = [sum(float(row[axis]) for row in rows) / len(rows) for axis in (1, 2, 3)] if kind == "other" else [0, 0, 0]
    shift = [-middle[0], -middle[1], HEIGHT_M * number - middle[2]]
    with open(folder / drive / "poses.txt", "w", encoding="utf-8") as file:
        for row in rows:
            moved = [repr(float(row[1 + axis]) + shift[axis]) for axis in range(3)]
            file.write(" ".join([row[0], *moved, *row[4:]]) + "\n")
    return folder, drive, shift


def hypothesis_is_right(answer, truth):
    T, position = answer["T_map_query"], answer["pose"]["position"]
    way = [position[axis] - T[4 * axis + 3] for axis in range(3)]
    in_query = [sum(T[4 * row + axis] * way[row] for row in range(3)) for axis in range(3)]

    def lies_there(h):
        U = h["T_map_query"]
        here = [sum(U[4 * row + axis] * in_query[axis] for axis in range(3)) + U[4 * row + 3] for row in range(3)]
        return math.dist(here, truth) < 2 * RIGHT_M
    return any(lies_there(h) for h in answer["hypotheses"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/xview"))
    parser.add_argument("--floors", type=int, default=4)
    parser.add_argument("--seeds", default="5201,5301")
    parser.add_argument("--kinds", default="other,mould,same")
    parser.add_argument("--work", type=Path, default=ROOT / "build/floors")
    parser.add_argument("--raw", action="store_true")
    parser.add_argument("--cloud", action="store_true")
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    labels = ["--labels", "shapes"] if given.raw else []
    rows, wrong = [], 0
    for kind in given.kinds.split(","):
        count = {"windows": 0, "right": 0, "accepted": 0, "named": 0, "wrong": 0}
        for seed in map(int, given.seeds.split(",")):
            floors = [floor_of(given.program, given.work, kind, seed, number, given.floors)
                      for number in range(given.floors)]
            name = f"{kind}_{seed}_{given.floors}" + "_raw" * given.raw + "_cloud" * given.cloud
            place = given.work / f"{name}.xvm"
            drives = [folder / drive for folder, drive, _ in floors]
            run(given.program, "map", *drives, place, "-q", *labels)
            if given.cloud:
                cloud = place.with_suffix(".pcd")
                run(given.program, "lift", place, cloud, "-q")
                place.unlink()
                run(given.program, "map", cloud, place, "-q", *labels)
            for folder, _, shift in floors:
                truths = poses(folder / "rear/groundtruth.txt")
                for frames in WINDOWS:
                    lines = run(given.program, "localize", folder / "rear", place, "--window", frames, "--stride",
                                max(4, frames // 2), "--json", "-q", *labels).splitlines()
                    for answer in map(json.loads, lines):
                        count["windows"] += 1
                        if not answer.get("pose"):
                            continue
                        row = truths[answer["query"]["last_frame"]]
                        truth = [float(row[1 + axis]) + shift[axis] for axis in range(3)]
                        is_right = math.dist(answer["pose"]["position"], truth) < RIGHT_M
                        count["right"] += is_right
                        if answer["status"] == "accepted":
                            count["accepted" if is_right else "wrong"] += 1
                        elif answer["status"] == "ambiguous":
                            count["named"] += is_right or hypothesis_is_right(answer, truth)
        rows.append([kind, *map(str, count.values())])
        print(" | ".join(rows[-1]), flush=True)
        wrong += count["wrong"]
    print(table([["floors", "windows", "right", "accepted", "ambiguous, the right one named", "accepted wrong"],
                 *rows]))
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main())
