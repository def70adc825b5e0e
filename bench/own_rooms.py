#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Simulated rooms of three makes: windows of a second walk in the map of a first one.

    bench/own_rooms.py [--program build/xview] [--other-worlds build/bench/other_worlds] [--makes office,warehouse,home]
                       [--seeds 9101,9102] [--metres 4,8] [--raw] [--turned] [--per-row 15] [--work FOLDER] [--jobs 2]

Offices are of `xview simulate` (83 % of the pixels labelled right), warehouses and homes of bench/other_worlds (88 %),
which shares no code with it; --raw: labels are withheld on both sides. Cameras look back or aside, with an odometry of
their own, which --turned turns by any rotation. Each window is also searched for in the room of the next seed. Prints a
row per make and length; exit code 1 if something is accepted further off than half a metre, or elsewhere.
"""
import argparse
import json
import math
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table
from regress_poses import from_numbers, product
from regress_worlds import lines_of, random_of

ROOT = Path(__file__).resolve().parent.parent
RIGHT_M, WRONG_M = 0.2, 0.5
MAP, QUERIES = "forward", ("rear", "oblique")


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(done.stderr)
    return done.stdout


def any_rotation(*name):
    """The same for the same name."""
    chance = random_of("turn", *name)
    quaternion = [chance.gauss(0, 1) for _ in range(4)]
    return from_numbers(["0", "0", "0", "0", *quaternion])


def world(given, make, seed):
    folder = given.work / f"{make}_{seed}"
    if not folder.exists():
        part = folder.with_name(folder.name + ".part")
        shutil.rmtree(part, ignore_errors=True)
        if make == "office":
            run(given.program, "simulate", part, "--seed", seed, "--sim.style", "office", "--sessions.aerial=false",
                "--sessions.oblique=true", "--quality", "noisy", "--label_noise.accuracy", "0.83", "--drift", "0.01",
                "-q")
        else:
            run(given.other_worlds, make, seed, part, MAP, *QUERIES)
        part.replace(folder)
    return folder


def turned(given, recording, *name):
    """The recording with its odometry in a frame that is turned."""
    folder = given.work / "_".join(["turned", *map(str, name)])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for file in recording.iterdir():
        if file.name != "poses.txt":
            os.symlink(file.resolve(), folder / file.name)
    turn = any_rotation(*name)
    with open(folder / "poses.txt", "w", encoding="utf-8") as out:
        for words in lines_of(recording / "poses.txt"):
            T = product(turn, from_numbers(words))
            out.write(" ".join(repr(T[row][column]) for row in range(3) for column in range(4)) + "\n")
    return folder


def windows(recording, metres, count):
    at = [[T[axis][3] for axis in range(3)] for T in map(from_numbers, lines_of(recording / "poses.txt"))]
    step = sum(math.dist(a, b) for a, b in zip(at, at[1:])) / (len(at) - 1)
    frames = max(2, round(metres / step))
    if frames > len(at):
        return None
    return ["--window", frames, "--stride", max(1, (len(at) - frames) // max(1, count - 1))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/xview"))
    parser.add_argument("--other-worlds", default=str(ROOT / "build/bench/other_worlds"))
    parser.add_argument("--makes", default="office,warehouse,home")
    parser.add_argument("--seeds", default="9101,9102")
    parser.add_argument("--metres", default="4,8")
    parser.add_argument("--raw", action="store_true")
    parser.add_argument("--turned", action="store_true")
    parser.add_argument("--per-row", type=int, default=15)
    parser.add_argument("--work", type=Path, default=ROOT / "build/own_rooms")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    labels = ["--labels", "shapes"] if given.raw else []
    seeds = [int(seed) for seed in given.seeds.split(",")]
    pairs = [(make, seed) for make in given.makes.split(",") for seed in seeds]

    def prepare(pair):
        folder = world(given, *pair)
        place = folder / ("raw.xvm" if given.raw else "map.xvm")
        place.unlink(missing_ok=True)
        run(given.program, "map", folder / MAP, place, "-q", "--threads", "1", *labels)
        return place

    def ask(job):
        (make, seed), session, metres, place, is_own = job
        recording = world(given, make, seed) / session
        flags = windows(recording, metres, given.per_row)
        if flags is None:
            return 0, 0, 0, 0, 0, []
        query = turned(given, recording, make, seed, session, metres, is_own) if given.turned else recording
        lines = run(given.program, "localize", query, place, "--json", "-q", "--threads", "1", *flags, *labels)
        answers = [json.loads(line) for line in lines.splitlines()]
        truths = [from_numbers(words) for words in lines_of(recording / "groundtruth.txt")]
        right = accepted = off = 0
        wrong = []
        for answer in answers:
            off_m = math.inf
            if is_own and answer.get("pose"):
                T = truths[answer["query"]["last_frame"]]
                off_m = math.dist(answer["pose"]["position"], [T[axis][3] for axis in range(3)])
            right += off_m < RIGHT_M
            if answer["status"] == "accepted":
                accepted += off_m < RIGHT_M
                off += RIGHT_M <= off_m <= WRONG_M
                if off_m > WRONG_M:
                    wrong.append(f"{recording} {answer['query']['first_frame']}..{answer['query']['last_frame']}: "
                                 f"{off_m:.2f} m, p_wrong {answer['p_wrong']:.2g}")
        return len(answers), right, accepted, off, len(wrong), wrong

    with ThreadPoolExecutor(given.jobs) as pool:
        maps = dict(zip(pairs, pool.map(prepare, pairs)))
        rows, total_wrong = [], 0
        for make in given.makes.split(","):
            for metres in map(float, given.metres.split(",")):
                jobs = []
                for seed, other in zip(seeds, seeds[1:] + seeds[:1]):
                    for session in QUERIES:
                        jobs += [((make, seed), session, metres, maps[make, room], room == seed)
                                 for room in dict.fromkeys((seed, other))]
                done = list(pool.map(ask, jobs))
                own = [sum(d[i] for job, d in zip(jobs, done) if job[4]) for i in range(5)]
                others = [sum(d[i] for job, d in zip(jobs, done) if not job[4]) for i in range(5)]
                for d in done:
                    for text in d[5]:
                        print("accepted wrong:", text, flush=True)
                rows.append([make, f"{metres:g} m", *map(str, own), f"{others[4]} of {others[0]}"])
                print(" | ".join(rows[-1]), flush=True)
                total_wrong += own[4] + others[4]
    print(table([["make", "window", "queries", "within 0.2 m", "accepted of them", "accepted 0.2 to 0.5 m off", "wrong",
                  "other rooms accepted"], *rows]))
    return total_wrong > 0


if __name__ == "__main__":
    sys.exit(main())
