#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Recorded rooms without labels, each query in the map of its own place and of every other one.

    bench/rooms.py DATA [--program build/xview] [--jobs 1]

DATA has the folders tls_corridor, apartment, kitchen, outdoor_tilted, rgbd_7scenes, rgbd_sun3d. Prints a row per pair of
one place, and what is accepted of pairs of two places and of mirrored clouds. The error is that of the frame of
the query. Exit code 1 if something of another place is accepted.
"""
import argparse
import json
import math
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table

ROOT = Path(__file__).resolve().parent.parent
# place: map, queries with their truths, mirrored queries
PLACES = {
    "apartment": ("map.pcd", {"query.pcd": "query_truth.txt"}, []),
    "tls_corridor": ("map.pcd", {"query_1.pcd": "query_1_truth.txt", "query_2.pcd": "query_2_truth.txt"},
                     ["query_1_left_handed.pcd", "query_2_left_handed.pcd"]),
    "kitchen": ("map.ply", {"query_4.ply": "query_4_truth.txt", "query_g.pcd": "query_g_truth.txt"}, []),
    "outdoor_tilted": ("map.pcd", {"query_1.pcd": "query_1_truth.txt", "query_2.pcd": "query_2_truth.txt"}, []),
    "rgbd_7scenes": ("map", {"query": "query/truth.txt"}, []),
    "rgbd_sun3d": ("map", {"query": "query/truth.txt"}, []),
}
SAME_PLACE = {("kitchen", "rgbd_7scenes"), ("rgbd_7scenes", "kitchen")}  # one scene of 7-Scenes


def matrix(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    numbers = [float(word) for word in " ".join(lines).split()]
    return [numbers[4 * row:4 * row + 4] for row in range(3)]


def error(answer, truth):
    """Distance between two poses of the frame of a query [m], and angle between them [deg]."""
    found = [answer["T_map_query"][4 * row:4 * row + 4] for row in range(3)]
    trace = sum(found[row][axis] * truth[row][axis] for row in range(3) for axis in range(3))
    return (math.dist([row[3] for row in found], [row[3] for row in truth]),
            math.degrees(math.acos(max(-1, min(1, (trace - 1) / 2)))))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--program", default=str(ROOT / "build/xview"))
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()

    def ask(pair):
        place, query, of = pair
        out = subprocess.run([given.program, "localize", given.data / place / query, given.data / of / PLACES[of][0],
                              "--json", "-q", "--threads", "1"], capture_output=True, text=True)
        if out.returncode not in (0, 3):
            sys.exit(out.stderr)
        return json.loads(out.stdout)

    own = [(place, query, place) for place, (_, queries, _) in PLACES.items() for query in queries]
    others = [(place, query, of) for place, (_, queries, _) in PLACES.items() for query in queries for of in PLACES
              if of != place and (place, of) not in SAME_PLACE]
    mirrored = [(place, query, place) for place, (_, _, wrong) in PLACES.items() for query in wrong]
    with ThreadPoolExecutor(given.jobs) as pool:
        rows = [["query", "status", "p_wrong", "error", "features asked"]]
        for (place, query, _), answer in zip(own, pool.map(ask, own)):
            off_m, off_deg = error(answer, matrix(given.data / place / PLACES[place][1][query]))
            rows.append([f"{place}/{query}", answer["status"], f"{answer['p_wrong']:.2g}",
                         f"{off_m:.3f} m, {off_deg:.1f} deg", "yes" if "features" in answer["timing_ms"] else "no"])
        print(table(rows), "\n", sep="")
        accepted = 0
        for name, pairs in (("of another place", others), ("mirrored", mirrored)):
            wrong = [pair for pair, answer in zip(pairs, pool.map(ask, pairs)) if answer["status"] == "accepted"]
            print(f"{name}: {len(wrong)} of {len(pairs)} accepted", *wrong, sep="\n    ")
            accepted += len(wrong)
    return accepted > 0


if __name__ == "__main__":
    sys.exit(main())
