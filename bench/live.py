#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Follows robots that are carried away by `xview follow` and writes docs/results/live.md.

A drive of 1 km through a simulated town that sets nothing (camera: looking back, in the map of a drive that looks forward, 83 % of the
labels right, stereo depth, 1 % drift; scanner: the other way round) is cut into four parts, which are followed in another order: three times the
robot goes on a hundred metres and more away. *Shown*: there the odometry jumps; *hidden*: it goes on as if nobody had carried the robot.
"""
import argparse
import datetime
import json
import math
import os
import shutil
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

sys.dont_write_bytecode = True
from fused_drives import median, quantile
from paper_page import table, wrapped
from regress import simulated
from regress_poses import inverse, product
from regress_worlds import matrices_in

ROOT = Path(__file__).resolve().parent.parent
PARTS = ((0.0, 0.25), (0.6, 0.85), (0.3, 0.5), (0.75, 1.0))  # of the drive, in the order in which they are followed
SENSORS = {"camera": ("forward", "rear"), "scanner": ("lidar", "lidar_reverse")}
WRONG_M = 5
SOON_M = 20
JUMP = [[1, 0, 0, 500], [0, 1, 0, -200], [0, 0, 1, 3], [0, 0, 0, 1]]

Followed = namedtuple("Followed", "frames errors travels latencies_ms")


def cut(recording, folder, is_shown):
    """Writes the parts of a recording as one; where each frame was, and which ones come right after the robot was carried."""
    truth, odometry = (matrices_in(recording / name) for name in ("groundtruth.txt", "poses.txt"))
    is_scanner = (recording / "velodyne").is_dir()
    shutil.rmtree(folder, ignore_errors=True)
    files = {source.name: sorted(source.iterdir()) for source in recording.iterdir() if source.is_dir()}
    for name in files:
        (folder / name).mkdir(parents=True)
    for name in ("camera.yaml", "classes.yaml", "calib.txt"):
        if (recording / name).exists():
            shutil.copy(recording / name, folder / name)
    where, carried, lines, last = [], [], [], None
    for number, (begin, end) in enumerate(PARTS):
        first = int(begin * len(truth))
        begins_at = last or odometry[first]
        if number and is_shown:
            begins_at = product(JUMP, begins_at)
        T = product(begins_at, inverse(odometry[first]))
        carried += [len(where)] if number else []
        for i in range(first, int(end * len(truth))):
            last = product(T, odometry[i])
            lines.append(" ".join(f"{v:.9f}" for row in last[:3] for v in row))
            for name, of_frames in files.items():
                os.link(of_frames[i], folder / name / f"{len(where):06d}{of_frames[i].suffix}")
            where.append([row[3] for row in truth[i][:3]])
    (folder / "poses.txt").write_text("\n".join(lines) + "\n")
    if is_scanner:
        (folder / "times.txt").write_text("".join(f"{0.5 * k:.1f}\n" for k in range(len(where))))
    return where, carried


def followed(program, recording, town_map, folder, is_shown):
    where, carried = cut(recording, folder, is_shown)
    done = subprocess.run([str(program), "follow", str(folder), str(town_map), "--threads", "1", "-q"], capture_output=True, text=True)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    if len(lines) != len(where):
        sys.exit(f"{folder}: {len(lines)} lines for {len(where)} frames: {done.stderr}")
    errors = {k: math.dist(line["pose"]["position"], where[k]) for k, line in enumerate(lines) if line["pose"]}
    travels = []
    for first, end in zip([0, *carried], [*carried, len(where)]):
        travel = 0.0
        for k in range(first, end):
            travel += math.dist(where[k], where[k - 1]) if k > first else 0
            if k in errors and errors[k] <= WRONG_M:
                travels.append(travel)
                break
        else:
            travels.append(math.inf)
    return Followed(len(where), list(errors.values()), travels, [line["latency_ms"] for line in lines])


def row_of(name, runs):
    errors = [e for run in runs for e in run.errors]
    again = [t for run in runs for t in run.travels[1:]]
    latencies = [ms for run in runs for ms in run.latencies_ms]
    frames = sum(run.frames for run in runs)
    return [name, len(runs), frames, f"{100 * len(errors) / frames:.0f}", sum(e > WRONG_M for e in errors), f"{median(errors):.2f}",
            f"{max((e for e in errors if e <= WRONG_M), default=math.nan):.2f}", f"{sum(t <= SOON_M for t in again)} of {len(again)}",
            f"{median(again):.1f}", f"{max(again):.1f}", f"{median(latencies):.0f}", f"{quantile(latencies, 0.99):.0f}"]


HEADING = ["sensor, odometry", "drives", "frames", "with a pose, %", f"poses more than {WRONG_M} m off", "error, m, median",
           "most of the others", f"found again within {SOON_M} m of travel", "travel until found, m, median", "most",
           "time per frame, ms, median", "99 of 100 less than"]

PAGE = """# Live

Written by `./run live` on {made}; do not edit. {doc}

{rows}

One thread. Most frames of a camera end no query: they are held against the place where they are expected, and one that does not fit there ends the pose
at once. The most of a camera's time is that of a query.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", type=Path, default=ROOT / "build/xview")
    parser.add_argument("--work", type=Path, default=Path("build/live"), help="folder for towns and maps")
    parser.add_argument("--towns", type=int, default=4)
    parser.add_argument("--page", type=Path, default=ROOT / "docs/results/live.md")
    given = parser.parse_args()
    program, work = given.program.resolve(), given.work.resolve()
    (work / "worlds").mkdir(parents=True, exist_ok=True)
    runs = {(sensor, way): [] for sensor in SENSORS for way in ("shown", "hidden")}
    for number in range(given.towns):
        flags = ["--seed", str(3100 + number), "--quality", "noisy", "--route_length_m", "1000", "--sessions.lidar", "--sessions.aerial=false"]
        town = simulated(program, work, f"town_{number}", flags)
        for sensor, (forward, back) in SENSORS.items():
            town_map = work / f"{sensor}_{number}.xvm"
            if not town_map.exists():
                subprocess.run([str(program), "map", str(town / forward), str(town_map), "-q"], check=True, stdout=subprocess.DEVNULL)
            for way in ("shown", "hidden"):
                run = followed(program, town / back, town_map, work / "cut", way == "shown")
                print(number, sensor, way, row_of("", [run])[2:], file=sys.stderr, flush=True)
                runs[sensor, way].append(run)
    rows = [row_of(f"{sensor}, {way}", of_kind) for (sensor, way), of_kind in runs.items()]
    doc = " ".join(__doc__.split("\n\n")[1].split())
    given.page.write_text(wrapped(PAGE.format(made=datetime.date.today(), doc=doc, rows=table([HEADING, *rows]))))


if __name__ == "__main__":
    main()
