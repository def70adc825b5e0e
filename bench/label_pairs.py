#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A simulated drive in the classes of each shipped label set, sought through the program in maps of every other set.

    bench/label_pairs.py [--program build/xview] [--work /tmp/label_pairs] [--jobs 1]

Prints the pairs that are accepted, those refused, and the largest error of those accepted. Exit code 1 if an accepted
pose is wrong, or a drive of another town is accepted.
"""
import argparse
import json
import math
import shutil
import subprocess
import sys
from array import array
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Classes of airsim are numbers of things, and those of nyu40 are of rooms.
LEFT_OUT = {"airsim", "nyu40"}
WRONG_M = 1
SCENE = ["--width", "320", "--height", "240", "--route_length_m", "200", "--sessions.lidar", "--quiet"]


def classes_of(path):
    """Names to ids."""
    ids = {}
    for line in path.read_text().splitlines():
        if line.strip().startswith("- {id:"):
            fields = dict(part.strip().split(": ", 1) for part in line.strip()[3:-1].split(", ") if ": " in part)
            ids[fields["name"].strip('"')] = int(fields["id"])
    return ids


class Drives:
    def __init__(self, program, work):
        self.program, self.work = program, work

    def ask(self, *arguments, codes=(0,)):
        out = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True)
        if out.returncode not in codes:
            sys.exit(f"{arguments}: {out.stderr}")
        return out.stdout

    def simulate(self, name, seed):
        self.ask("simulate", self.work / name, "--seed", seed, *SCENE)

    def in_set(self, drive, labels):
        """A copy whose classes are those of a set: what has no partner there is unknown."""
        there = self.work / f"{drive.parent.name}_{drive.name}_{labels.stem}"
        if there.exists():
            return there
        shutil.copytree(drive, there)
        if labels.stem == "shapes":
            (there / "classes.yaml").unlink()
            shutil.rmtree(there / "labels")
            return there
        shutil.copy(labels, there / "classes.yaml")
        partners = json.loads(self.ask("info", drive, there, "--json"))["partners"]
        own, theirs = classes_of(drive / "classes.yaml"), classes_of(labels)
        of = {own[pair["query"]]: theirs[pair["map"]] for pair in partners}
        for file in (there / "labels").iterdir():
            ids = array("I", file.read_bytes())
            file.write_bytes(array("I", (of.get(label & 0xFFFF, 0) for label in ids)).tobytes())
        return there


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/xview"))
    parser.add_argument("--work", type=Path, default=Path("/tmp/label_pairs"))
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    shutil.rmtree(given.work, ignore_errors=True)
    given.work.mkdir(parents=True)
    drives = Drives(given.program, given.work)
    drives.simulate("town", 3)
    drives.simulate("other", 4)
    sets = [path for path in sorted((ROOT / "config/labels").glob("*.yaml")) if path.stem not in LEFT_OUT]
    queries = [drives.in_set(given.work / "town/lidar_reverse", labels) for labels in sets]
    foreign = [drives.in_set(given.work / "other/lidar_reverse", labels) for labels in sets]

    def answers(labels):
        city = given.work / f"{labels.stem}.xvm"
        drives.ask("map", drives.in_set(given.work / "town/lidar", labels), city, "-q")
        lines = drives.ask("localize", *queries, *foreign, city, "--json", "-q", "--threads", "1", codes=(0, 3))
        return [json.loads(line) for line in lines.splitlines()]

    def last_row(name):
        return [float(word) for word in (given.work / "town/lidar_reverse" / name).read_text().split("\n")[-2].split()]

    sensor, truth = last_row("poses.txt")[3:12:4], last_row("groundtruth.txt")[1:4]
    accepted, refused, wrong, largest_m = 0, [], [], 0
    with ThreadPoolExecutor(given.jobs) as pool:
        for labels, found in zip(sets, pool.map(answers, sets)):
            for of, answer in zip(sets + sets, found):
                pair = f"{of.stem} in {labels.stem}"
                is_foreign = "other_" in answer["query"]["input"]
                if answer["status"] != "accepted":
                    refused += [] if is_foreign else [f"{pair}: {answer['reason']}"]
                    continue
                T = answer["T_map_query"]
                found_at = [sum(a * b for a, b in zip(T[4 * row:], sensor)) + T[4 * row + 3] for row in range(3)]
                off_m = math.inf if is_foreign else math.dist(found_at, truth)
                accepted += not is_foreign
                if off_m > WRONG_M:
                    wrong.append(f"{pair}{' of the other town' if is_foreign else ''}: {off_m:.2f} m off")
                else:
                    largest_m = max(largest_m, off_m)
    print(f"{accepted} of {len(sets) ** 2} pairs accepted, largest error of those right {largest_m:.3f} m, "
          f"{len(wrong)} wrong of {2 * len(sets) ** 2}")
    print("refused:", *refused, sep="\n    ")
    print("wrong:", *wrong, sep="\n    ")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
