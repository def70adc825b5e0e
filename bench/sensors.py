#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Any sensor in the map of any other: one matrix per world.

    bench/sensors.py [--program build/xview] [--scanners build/bench/scanners] [--worlds oldtown:5,village_slope:5]
                     [--sensors hdl64,vlp16,...] [--maps hdl64,...] [--metres 20] [--windows 6] [--raw] [--work FOLDER]
                     [--jobs 2]

Sensors are those of bench/scanners, with 10 % of the patches labelled wrong or (--raw) no labels. A query is a window
of a second visit the other way round, whose odometry begins with the identity however its sensor is mounted. Queries
from the air are discs of 60 m. A cell says how many windows are accepted within half a metre, and how many are right
so; with ~ the number that was accepted further off, with ! of those further off than two metres (half a metre in rooms),
and ? where the map is of another world. Exit code 1 if there is a ! or a ?.
"""
import argparse
import json
import math
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table
from regress_poses import from_numbers
from regress_worlds import lines_of

ROOT = Path(__file__).resolve().parent.parent
SENSORS = ("hdl64", "os1_128", "vlp16", "xt32", "qt64", "avia", "mid360", "mid360_hanging", "fmcw", "rgbd", "stereo",
           "phone", "airborne", "photogrammetry")
ROOMS = ("warehouse", "home")
RIGHT_M = 0.5


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


def positions(file):
    return [[T[axis][3] for axis in range(3)] for T in map(from_numbers, lines_of(file))]


def windows(recording, metres, count):
    at = positions(recording / "poses.txt")
    step = sum(math.dist(a, b) for a, b in zip(at, at[1:])) / (len(at) - 1)
    frames = max(1, round(metres / step))
    return ["--window", frames, "--stride", max(1, (len(at) - frames) // count)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/xview"))
    parser.add_argument("--scanners", default=str(ROOT / "build/bench/scanners"))
    parser.add_argument("--worlds", default="oldtown:5,village_slope:5")
    parser.add_argument("--sensors", default=",".join(SENSORS))
    parser.add_argument("--maps", help="sensors of the maps; all of --sensors by default")
    parser.add_argument("--metres", type=float, default=20)
    parser.add_argument("--windows", type=int, default=6)
    parser.add_argument("--raw", action="store_true")
    parser.add_argument("--work", type=Path, default=ROOT / "build/sensors")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    sensors = given.sensors.split(",")
    of_maps = (given.maps or given.sensors).split(",")
    labels = ["--labels", "shapes"] if given.raw else []
    worlds = [tuple(world.split(":")) for world in given.worlds.split(",")]

    def labels_of(cloud):
        """Clouds say nothing of what their classes are called."""
        return labels or (["--labels", cloud.parent / "classes.yaml"] if cloud.exists() else [])

    def prepare(job):
        style, seed, sensor = job
        folder = given.work / f"{style}_{seed}" / sensor
        if not folder.exists():
            part = folder.with_name(folder.name + ".part")
            shutil.rmtree(part, ignore_errors=True)
            run(given.scanners, style, seed, part, sensor)
            part.replace(folder)
        if sensor in of_maps:
            place = folder / ("raw.xvm" if given.raw else "map.xvm")
            place.unlink(missing_ok=True)
            cloud = folder / "map/cloud.ply"
            run(given.program, "map", cloud if cloud.exists() else folder / "map", place, "-q", "--threads", "1",
                *labels_of(cloud))

    def ask(job):
        (style, seed), sensor, of_map, of_world = job
        query = given.work / f"{style}_{seed}" / sensor / "query"
        place = given.work / "_".join(of_world) / of_map / ("raw.xvm" if given.raw else "map.xvm")
        clouds = sorted(query.glob("disc_*.ply"))
        flags = [] if clouds else windows(query, given.metres, given.windows)
        lines = run(given.program, "localize", *(clouds or [query]), place, "--json", "-q", "--threads", "1", *flags,
                    *labels_of(query / "disc_0.ply"))
        truths = positions(query / "groundtruth.txt")
        wrong_m = RIGHT_M if style in ROOMS else 4 * RIGHT_M
        count = right = accepted = off = wrong = 0
        reasons = {}
        for answer in map(json.loads, lines.splitlines()):
            at = count if clouds else answer["query"]["last_frame"]
            count += 1
            off_m = math.inf
            if answer.get("pose") and of_world == (style, seed):
                off_m = math.dist(answer["pose"]["position"], truths[at])
            right += off_m < RIGHT_M
            if answer["status"] == "accepted":
                accepted += off_m < RIGHT_M
                off += RIGHT_M <= off_m <= wrong_m
                wrong += off_m > wrong_m
                if off_m > wrong_m:
                    print(f"accepted wrong: {query} in {place}, {answer['query']}, {off_m:.2f} m", flush=True)
            elif off_m < RIGHT_M:
                reasons[answer["reason_code"]] = reasons.get(answer["reason_code"], 0) + 1
        return count, right, accepted, wrong, off, reasons

    total_wrong = 0
    with ThreadPoolExecutor(given.jobs) as pool:
        list(pool.map(prepare, [(*world, sensor) for world in worlds for sensor in dict.fromkeys(sensors + of_maps)]))
        for world, other in zip(worlds, worlds[1:] + worlds[:1]):
            cells = [(sensor, of_map) for sensor in sensors for of_map in of_maps]
            own = dict(zip(cells, pool.map(ask, [(world, *cell, world) for cell in cells])))
            elsewhere = {}
            if other != world:
                elsewhere = dict(zip(cells, pool.map(ask, [(world, *cell, other) for cell in cells])))
            rows = [["query \\ map", *of_maps]]
            for sensor in sensors:
                row = [sensor]
                for of_map in of_maps:
                    count, right, accepted, wrong, off, _ = own[sensor, of_map]
                    strangers = elsewhere[sensor, of_map][3] if elsewhere else 0
                    row.append(f"{accepted}/{right}/{count}" + f" ~{off}" * (off > 0) + f" !{wrong}" * (wrong > 0) +
                               f" ?{strangers}" * (strangers > 0))
                    total_wrong += wrong + strangers
                rows.append(row)
            print(f"{world[0]} {world[1]}, accepted/right/windows:\n\n{table(rows)}\n", flush=True)
            sums = [sum(cell[i] for cell in own.values()) for i in range(5)]
            refused = {}
            for cell in own.values():
                for code, times in cell[5].items():
                    refused[code] = refused.get(code, 0) + times
            strangers = [sum(cell[i] for cell in elsewhere.values()) for i in (0, 3)]
            print(f"{sums[0]} windows, {sums[1]} right, {sums[2]} accepted, {sums[4]} accepted further off, "
                  f"{sums[3]} wrong; right ones refused: "
                  f"{refused}; of another world {strangers[1]} of {strangers[0]} accepted\n", flush=True)
    return total_wrong > 0


if __name__ == "__main__":
    sys.exit(main())
