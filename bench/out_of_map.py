#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Windows of one world in the map of another one of the same make: how many are accepted?

    bench/out_of_map.py [--program build/xview] [--seeds 4711,4712,4713,4714] [--styles suburb,grid,...] [--work FOLDER]

Worlds of each style are simulated with usual labels (83 % of the pixels right) and mapped; windows of the sessions
back and aside of every other seed of the style are localized in each map. Prints a row per style, and a line per
accepted window. Worlds and answers are kept in --work. Exit code 1 if more than 3 in 5,000 are accepted.
"""
import argparse
import itertools
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table

ROOT = Path(__file__).resolve().parent.parent
LENGTHS = {"office": (15, 40)}  # frames of a window
OUTDOORS = (8, 15)


def world(program, work, style, seed):
    folder = work / f"{style}_{seed}"
    if not (folder / "map.xvm").exists():
        subprocess.run([program, "simulate", folder, "--seed", str(seed), "--sim.style", style, "--sessions.aerial=false",
                        "--quality", "noisy", "--label_noise.accuracy", "0.83", "--drift", "0.01", "-q"], check=True)
        subprocess.run([program, "map", folder / "forward", folder / "map.xvm", "-q", "--threads", "1"], check=True)
    return folder


def answers(program, query, place, frames, kept):
    if not kept.exists():
        out = subprocess.run([program, "localize", query, place / "map.xvm", "--window", str(frames), "--stride",
                              str(max(4, frames // 2)), "--json", "-q", "--threads", "1"], capture_output=True, text=True)
        if out.returncode not in (0, 3):
            sys.exit(out.stderr)
        kept.write_text(out.stdout)
    return [json.loads(line) for line in kept.read_text().splitlines()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/xview"))
    parser.add_argument("--seeds", default="4711,4712,4713,4714")
    parser.add_argument("--styles", default="suburb,grid,village,campus,office")
    parser.add_argument("--work", type=Path, default=ROOT / "build/out_of_map")
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    seeds = given.seeds.split(",")
    rows, asked, taken = [], 0, 0
    with ThreadPoolExecutor(given.jobs) as pool:
        for style in given.styles.split(","):
            folders = list(pool.map(lambda seed: world(given.program, given.work, style, seed), seeds))
            trials = [(query / session, place, frames)
                      for query, place in itertools.permutations(folders, 2)
                      for session in ("rear", "oblique") if (query / session).exists()
                      for frames in LENGTHS.get(style, OUTDOORS)]
            lists = pool.map(lambda t: answers(given.program, *t, given.work / "_".join(
                (t[0].parent.name, t[0].name, "in", t[1].name, f"{t[2]}.jsonl"))), trials)
            count = accepted = 0
            for trial, list_of in zip(trials, lists):
                count += len(list_of)
                for answer in list_of:
                    if answer["status"] == "accepted":
                        accepted += 1
                        print(f"{trial[0]} {answer['query']['first_frame']}-{answer['query']['last_frame']} in {trial[1].name}: "
                              f"p_wrong {answer['p_wrong']:.2g}: {answer['reason']}", flush=True)
            rows.append([style, str(count), str(accepted)])
            print(" | ".join(rows[-1]), flush=True)
            asked, taken = asked + count, taken + accepted
    print(table([["style", "windows", "accepted"], *rows, ["**all**", str(asked), str(taken)]]))
    return taken * 5000 > 3 * asked


if __name__ == "__main__":
    sys.exit(main())
