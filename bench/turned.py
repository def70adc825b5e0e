#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Clouds without labels that are turned by any rotation: are they found as they are when they stand upright?

    bench/turned.py [DATA] [--program build/xview] [--turns 4] [--work FOLDER] [--jobs 2]

The pairs are those of bench/raw_pairs.py, outdoors, and the clouds of bench/rooms.py. Each query is sought as it is and
by --turns random rotations of SO(3), as a scanner that hangs, leans or lies would have measured it. Right is within
0.5 m at the middle of the query, in rooms 0.2 m. Prints a row per pair, with the time of the program over that of the
query as it is; exit code 1 if a wrong place or a negative is accepted.
"""
import argparse
import math
import os
import statistics
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
from own_rooms import any_rotation
from paper_page import table
from raw_pairs import IDENTITY, error_m, middle_of, pairs, run_xview
from regress_poses import inverse, product
from rooms import PLACES, matrix

RIGHT_M, RIGHT_IN_ROOM_M = 0.5, 0.2


def recorded_pairs(data, made):
    """(name, query, map, T_map_query or None if the query is out of the map, how near is right [m])"""
    yield from ((*pair, RIGHT_M) for pair in pairs(data, made))
    for place, (of_map, queries, _) in PLACES.items():
        for query, truth in queries.items():
            if (data / place / query).is_file():
                T = matrix(data / place / truth) + [[0, 0, 0, 1]]
                yield f"{place} {Path(query).stem}", data / place / query, data / place / of_map, T, RIGHT_IN_ROOM_M


def turned(given, query, name, turn):
    """The query turned, and the rotation; as it is for turn 0."""
    if turn == 0:
        return query, IDENTITY
    R = any_rotation(name, turn)
    file, cloud = (given.work / f"{name.replace(' ', '_')}_{turn}{ending}" for ending in (".txt", ".pcd"))
    if not cloud.exists():
        file.write_text("\n".join(" ".join(map(str, row)) for row in R) + "\n")
        subprocess.run([given.program, "lift", query, cloud, "--transform", file, "-q"], check=True)
    return cloud, R


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", nargs="?", default=os.environ.get("XVIEW_DATA", "../shared/data"), type=Path)
    parser.add_argument("--program", default="build/xview", type=Path)
    parser.add_argument("--turns", type=int, default=4)
    parser.add_argument("--work", default="build/turned", type=Path)
    parser.add_argument("--jobs", default=2, type=int)
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    listed = list(recorded_pairs(given.data, given.work / "clouds"))

    def ask(job):
        (name, query, place, T_true, _), turn = job
        cloud, R = turned(given, query, name, turn)
        began = time.monotonic()
        answer = run_xview(given.program, cloud, place)
        took_s = time.monotonic() - began
        error = error_m(answer["T"], product(T_true, inverse(R)), middle_of(cloud)) if T_true else math.inf
        return answer["yes"], error, took_s

    rows, wrong = [], 0
    with ThreadPoolExecutor(given.jobs) as pool:
        jobs = [(pair, turn) for pair in listed for turn in range(1 + given.turns)]
        answers = dict(zip(((job[0][0], job[1]) for job in jobs), pool.map(ask, jobs)))
    for name, _, _, T_true, right_m in listed:
        upright, *others = (answers[name, turn] for turn in range(1 + given.turns))
        wrong += sum(yes and error > max(right_m, RIGHT_M) for yes, error, _ in (upright, *others))
        cells = [f"{sum(e <= right_m for _, e, _ in some)}, {sum(yes for yes, _, _ in some)}"
                 for some in ([upright], others)]
        ratio = statistics.median(s for _, _, s in others) / upright[2]
        rows.append([name + ("" if T_true else ": negative"), *cells, f"{ratio:.1f}"])
    print(table([["pair", "upright: right, accepted", f"of {given.turns} turned: right, accepted", "time"], *rows]))
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main())
