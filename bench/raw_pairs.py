#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pairs of clouds without labels or view-points: xview beside what PCL offers, on the same files.

Every query is sought in the cloud of its own place, and some in clouds of other places. A method says yes if it
accepts (xview), or converged (PCL). Right is within 0.3 m at the middle of the query. PCL's features of the map and
the index of xview are made before the clock runs. Prints a Markdown table; runs are kept in --work.
"""
import argparse
import json
import math
import os
import statistics
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
import regress_worlds as worlds
from regress_poses import from_numbers, inverse, product, turned_about_z

RIGHT_M = 0.3
METHODS = ("xview", "prerejective", "sac_ia")
NAMES = {"xview": "xview", "prerejective": "FPFH + SampleConsensusPrerejective + ICP", "sac_ia": "FPFH + SAC-IA + ICP"}
IDENTITY = turned_about_z(0)


def pairs(data, made):
    """(name, query, map, T_map_query or None if the query is out of the map)"""
    made.mkdir(parents=True, exist_ok=True)

    def cloud(name, folder):
        target = made / f"{name}.pcd"
        return target if target.exists() else worlds.fused(folder, target)

    kitti = {name: cloud(name, data / "kitti00" / name) for name in ("map", "query_4501", "negative_850")}
    truth = worlds.matrices_in(data / "kitti00" / "query_4501" / "truth.txt")[0]
    T_odom = next(iter(worlds.odometry_of(data / "kitti00" / "query_4501").values()))
    yield "kitti00 4501", kitti["query_4501"], kitti["map"], product(truth, inverse(T_odom))

    gone = (4, 16, 28)
    rest, _ = worlds.part_of(data / "nuscenes32", made / "rest", lambda i: i not in gone, IDENTITY)
    city = cloud("nuscenes32_rest", rest)
    sweeps = []
    for sweep in gone:
        move = worlds.random_move("raw_pairs", sweep)
        part, _ = worlds.part_of(data / "nuscenes32", made / f"sweep_{sweep}", lambda i: i == sweep, move)
        sweeps.append(cloud(f"nuscenes32_{sweep}", part))
        yield f"nuscenes32 {sweep}", sweeps[-1], city, inverse(move)

    panda = {name: cloud(name, data / "pandaset" / name) for name in ("pandar64", "pandargt")}
    T = from_numbers(sum(worlds.lines_of(data / "pandaset" / "pandargt" / "truth.txt"), []))
    yield "pandaset pandargt", panda["pandargt"], panda["pandar64"], T

    T = from_numbers(sum(worlds.lines_of(data / "registration" / "T_target_source.txt"), []))
    yield "registration", data / "registration" / "source.ply", data / "registration" / "target.ply", T

    teach = data / "laser_teach_repeat"
    for scan, place, *numbers in worlds.lines_of(teach / "truth.txt")[::2]:
        yield f"laser_teach_repeat {scan}", teach / f"{scan}.pcd", teach / f"{place}.pcd", from_numbers(numbers)

    yield "kitti00 850", kitti["negative_850"], kitti["map"], None
    yield "kitti00 850 in nuscenes32", kitti["negative_850"], city, None
    yield "kitti00 4501 in pandaset", kitti["query_4501"], panda["pandar64"], None
    yield "nuscenes32 16 in kitti00", sweeps[1], kitti["map"], None
    yield "pandaset pandargt in kitti00", panda["pandargt"], kitti["map"], None
    yield "kitti00 4501 in laser_teach_repeat", kitti["query_4501"], teach / "map_0.pcd", None
    yield "laser_teach_repeat in nuscenes32", teach / "scan_4.pcd", city, None


def middle_of(path):
    """Of the points of a PCD or PLY."""
    if path.suffix == ".ply":
        return worlds.middle_of(worlds.read_ply(path)[1])
    header, _, body = path.read_bytes().partition(b"DATA ")
    lines = {line.split()[0]: line.split()[1:] for line in header.decode().splitlines() if line and line[0] != "#"}
    kind, _, body = body.partition(b"\n")
    if kind == b"ascii":
        points = [[float(word) for word in line.split()[:3]] for line in body.decode().splitlines() if line.strip()]
    else:
        import struct
        stride = sum(int(s) * int(c) for s, c in zip(lines["SIZE"], lines["COUNT"]))
        count = int(lines["POINTS"][0])
        points = [struct.unpack_from("<3f", body, i * stride) for i in range(0, count)]
    points = [p for p in points if all(math.isfinite(v) for v in p[:3])]
    return worlds.middle_of(points)


def run_xview(program, query, place):
    run = subprocess.run([program, "localize", query, place, "--json", "--quiet", "--threads", "1"],
                         capture_output=True, text=True)
    answer = json.loads(run.stdout.splitlines()[-1])
    return {"yes": answer["status"] == "accepted", "sure": answer["confidence"],
            "s": answer["timing_ms"]["total"] / 1000, "T": answer.get("T_map_query")}


def run_pcl(bench, place, queries):
    """By query and method. The features of the place are made once."""
    run = subprocess.run([bench, place, *queries], capture_output=True, text=True, check=True)
    answers = [json.loads(line) for line in run.stdout.splitlines()]
    return [{a["method"]: {"yes": a["converged"], "sure": a["on_map"], "s": a["cpu_s"], "T": a["T_map_query"]}
             for a in answers[i:i + 2]} for i in range(0, len(answers), 2)]


def answers_in(place, queries, args):
    """By query one answer per method: says (yes or no), how sure, time, T_map_query."""
    kept = args.work / f"{place.parent.name}_{place.stem}.json"
    if not kept.exists():
        answers = run_pcl(args.bench, place, queries)
        for query, answer in zip(queries, answers):
            answer["xview"] = run_xview(args.program, query, place)
        kept.write_text(json.dumps(answers))
    return dict(zip(queries, json.loads(kept.read_text())))


def error_m(T_estimate, T_true, middle):
    if T_estimate is None:
        return math.inf
    at = [[1, 0, 0, middle[0]], [0, 1, 0, middle[1]], [0, 0, 1, middle[2]], [0, 0, 0, 1]]
    a, b = product(from_numbers(T_estimate), at), product(T_true, at)
    return math.dist([row[3] for row in a[:3]], [row[3] for row in b[:3]])


def cell(answer, T_true, error):
    says = "yes" if answer["yes"] else "no"
    where = "" if T_true is None else f"{error:.2f} m, " if error < 100 else "> 100 m, "
    return f"{where}{says} ({answer['sure']:.2f}), {answer['s']:.1f} s"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", nargs="?", default=os.environ.get("XVIEW_DATA", "../shared/data"), type=Path)
    parser.add_argument("--program", default="build/xview", type=Path)
    parser.add_argument("--bench", default="build/bench/fpfh_bench", type=Path)
    parser.add_argument("--work", default="build/raw_pairs", type=Path)
    parser.add_argument("--jobs", default=1, type=int)
    args = parser.parse_args()
    made = args.work / "clouds"
    print("| pair | " + " | ".join(NAMES[m] for m in METHODS) + " |\n" + "| --- " * (1 + len(METHODS)) + "|")
    right, strangers, seconds = ({m: [] for m in METHODS} for _ in range(3))
    queries, listed = {}, list(pairs(args.data, made))
    for _, query, place, _ in listed:
        queries.setdefault(place, []).append(query)
    with ThreadPoolExecutor(args.jobs) as pool:
        answers_of = dict(zip(queries, pool.map(lambda place: answers_in(place, queries[place], args), queries)))
    for name, query, place, T_true in listed:
        answers = answers_of[place][query]
        middle = middle_of(query) if T_true else None
        cells = []
        for method in METHODS:
            answer = answers[method]
            error = error_m(answer["T"], T_true, middle) if T_true else math.inf
            cells.append(cell(answer, T_true, error))
            seconds[method].append(answer["s"])
            (right if T_true else strangers)[method].append((answer["yes"], error <= RIGHT_M, answer["sure"]))
        print("| " + " | ".join([name] + cells) + " |", flush=True)
    own, other = len(right["xview"]), len(strangers["xview"])
    for title, count in (
            (f"right, of {own}", lambda m: sum(ok for _, ok, _ in right[m])),
            ("yes and right", lambda m: sum(yes and ok for yes, ok, _ in right[m])),
            (f"yes, but wrong, of {own}", lambda m: sum(yes and not ok for yes, ok, _ in right[m])),
            (f"yes to a negative, of {other}", lambda m: sum(yes for yes, _, _ in strangers[m])),
            ("least sure right answer", lambda m: f"{min((s for _, ok, s in right[m] if ok), default=0):.3f}"),
            ("surest negative", lambda m: f"{max(s for _, _, s in strangers[m]):.3f}"),
            ("median time", lambda m: f"{statistics.median(seconds[m]):.1f} s")):
        print("| **" + title + "** | " + " | ".join(str(count(m)) for m in METHODS) + " |")


if __name__ == "__main__":
    main()
