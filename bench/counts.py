#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What runs cost in counts that do not depend on how busy a machine is: instructions, page faults, memory.

    bench/counts.py [--program build/xview] [--data ../shared/data] [--work build/counts] [--table bench/counts.csv]
                    [--write] [--short] [ROW...]

Instructions are those that valgrind's callgrind counts, in millions; the same to 1e-6 from run to run of one build on
one machine; other libraries or processors change them by some percent. Page faults are minor ones, memory is the peak,
both of a run without callgrind. All of it on one thread. --short: the three rows that take least, and whatever grew by
more than 2 % of instructions against the table is named. --write: the table is written anew. What needs data that are
not there is left out, and said. Exit code 1 if a run fails.
"""
import argparse
import csv
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHORT = ("start", "registration", "kitti00")
GREW = 1.02
LOCALIZE = ("localize", "-q", "--threads", "1")
RAW = ("--labels", "shapes")
# row: its words; {data} and {work} are folders, a word that begins with + is made by the row of that name in MAPS
ROWS = {
    "start": ("--version",),
    "kitti00": (*LOCALIZE, "{data}/kitti00/query_4501", "+kitti00.xvm"),
    "laser_teach_repeat": (*LOCALIZE, "{data}/laser_teach_repeat/scan_3.pcd", "{data}/laser_teach_repeat/map_1.pcd"),
    "outdoor_tilted": (*LOCALIZE, "{data}/outdoor_tilted/query_1.pcd", "{data}/outdoor_tilted/map.pcd"),
    "registration": (*LOCALIZE, "{data}/registration/source.ply", "{data}/registration/target.ply"),
    "apartment": (*LOCALIZE, "{data}/apartment/query.pcd", "{data}/apartment/map.pcd"),
    "tls_corridor": (*LOCALIZE, "{data}/tls_corridor/query_1.pcd", "{data}/tls_corridor/map.pcd"),
    "window": (*LOCALIZE, "+town/rear", "+town.xvm", "--frames", "100:130"),
    "raw_scan": (*LOCALIZE, "+town/lidar", "+town.xvm", "--frames", "40:41", *RAW),
    "map_of_scans": ("map", "-q", "--threads", "1", "{data}/kitti00/map", "{work}/made.xvm"),
    "map_of_camera": ("map", "-q", "--threads", "1", "+town/forward", "{work}/made.xvm", "--frames", "0:60"),
}
MAPS = {
    "kitti00.xvm": ("map", "-q", "{data}/kitti00/map", "{work}/kitti00.xvm"),
    "town": ("simulate", "{work}/town", "-q", "--seed", "7", "--width", "640", "--height", "480", "--route_length_m",
             "600", "--sessions.lidar"),
    "town.xvm": ("map", "-q", "+town/forward", "{work}/town.xvm"),
}


class Runs:
    def __init__(self, given):
        self.program, self.data, self.work = given.program, given.data, given.work

    def words(self, row):
        words = []
        for word in row:
            if word.startswith("+"):
                self.make(word[1:].split("/")[0])
                word = "{work}/" + word[1:]
            words.append(word.format(data=self.data, work=self.work))
        return words

    def make(self, name):
        if (self.work / name).exists():
            return
        subprocess.run([self.program, *self.words(MAPS[name])], check=True, stdout=subprocess.DEVNULL)

    def measure(self, row):
        """Millions of instructions, page faults, MB."""
        command = [self.program, *self.words(row)]
        (self.work / "made.xvm").unlink(missing_ok=True)
        pid = os.posix_spawn(command[0], command, os.environ,
                             file_actions=[(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)])
        _, status, usage = os.wait4(pid, 0)
        if os.waitstatus_to_exitcode(status) not in (0, 3):
            sys.exit(f"failed: {' '.join(command)}")
        (self.work / "made.xvm").unlink(missing_ok=True)
        done = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        counted = re.search(r"Collected : (\d+)", done.stderr)
        if not counted:
            sys.exit(f"callgrind failed: {' '.join(command)}\n{done.stderr[-2000:]}")
        return int(counted[1]) / 1e6, usage.ru_minflt, usage.ru_maxrss / 1024


def has_data(runs, row):
    needed = [word for word in (*row, *(w for word in row if word.startswith("+") for w in MAPS[word[1:].split("/")[0]]))
              if word.startswith("{data}")]
    return all(Path(word.format(data=runs.data)).exists() for word in needed)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rows", nargs="*", metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--program", type=Path, default=ROOT / "build/xview")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared/data")
    parser.add_argument("--work", type=Path, default=ROOT / "build/counts")
    parser.add_argument("--table", type=Path, default=ROOT / "bench/counts.csv")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--short", action="store_true")
    given = parser.parse_args()
    for row in set(given.rows) - set(ROWS):
        parser.error(f"there is no row {row}; there are {', '.join(ROWS)}")
    if not shutil.which("valgrind"):
        print("counts: not counted, there is no valgrind")
        return
    given.program = given.program.resolve()
    given.work.mkdir(parents=True, exist_ok=True)
    known = {}
    if given.table.exists():
        with open(given.table, newline="") as file:
            known = {row["run"]: row for row in csv.DictReader(file)}
    runs = Runs(given)
    print("| run | M instructions | of the table | faults | MB |\n|---|---|---|---|---|")
    grown = []
    for name in given.rows or (SHORT if given.short else ROWS):
        if not has_data(runs, ROWS[name]):
            print(f"| {name} | left out: no data | | | |")
            continue
        instructions, faults, megabytes = runs.measure(ROWS[name])
        ratio = instructions / float(known[name]["m_instructions"]) if name in known else None
        print(f"| {name} | {instructions:.1f} | {f'{ratio:.3f}' if ratio else '-'} | {faults} | {megabytes:.0f} |",
              flush=True)
        if ratio and ratio > GREW:
            grown.append(f"{name} by {100 * (ratio - 1):.1f} %")
        known[name] = {"run": name, "m_instructions": f"{instructions:.1f}", "faults": faults, "mb": f"{megabytes:.0f}"}
    if grown:
        print("instructions grew: " + ", ".join(grown))
    if given.write:
        with open(given.table, "w", newline="") as file:
            writer = csv.DictWriter(file, ["run", "m_instructions", "faults", "mb"], lineterminator="\n")
            writer.writeheader()
            writer.writerows(known[name] for name in ROWS if name in known)


if __name__ == "__main__":
    main()
