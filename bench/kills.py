#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Kills `xview` (SIGKILL) again and again while it makes or changes files, and prints what it left as a table.

Each command is run once as a whole: that is what is new. Then, from the same files as before, it is killed COUNT times, every second
time at a random moment, otherwise some milliseconds after its first part or journal lies on the disk. What it leaves must be the old
output, the new one, or none where there was none; answers of `localize -o` may be fewer, but whole. Then the same command must end
with what is new, and nothing else may lie beside. Exit code 1 if anything is another.
"""
import argparse
import contextlib
import hashlib
import json
import random
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table

ROOT = Path(__file__).resolve().parent.parent


def commands(world):
    """What is killed: name, arguments, and the output of it among the files of the world."""
    forward, rear, lidar = (world / name for name in ("forward", "rear", "lidar"))
    return (
        ("map", ("map", forward, "{}/new.xvm"), "new.xvm"),
        ("map, over an older one", ("map", forward, "{}/half.xvm"), "half.xvm"),
        ("map --append", ("map", "--append", forward, "{}/half.xvm", "--frames", "30:45"), "half.xvm"),
        ("map --undo", ("map", "--undo", "{}/town.xvm"), "town.xvm"),
        ("map --without", ("map", "--without", forward, "{}/town.xvm"), "town.xvm"),
        ("map --join", ("map", "--join", forward, rear, "{}/joined.xvm"), "joined.xvm"),
        ("fuse", ("fuse", rear, "{}/half.xvm"), "half.xvm"),
        ("fuse --undo", ("fuse", "--undo", "{}/fused.xvm"), "fused.xvm"),
        ("prune", ("prune", "{}/visited.xvm", "--absent", "1"), "visited.xvm"),
        ("label", ("label", lidar, "{}/labelled"), "labelled"),
        ("simulate", ("simulate", "{}/made", "--route_length_m", "84", "--width", "160", "--height", "120"), "made"),
        ("lift", ("lift", forward, "{}/cloud.pcd"), "cloud.pcd"),
        ("localize -o", ("localize", rear, "{}/half.xvm", "--window", "8", "--stride", "4", "-o", "{}/answers.jsonl"), "answers.jsonl"),
    )


class Killer:
    def __init__(self, program, scratch, seed):
        self.program, self.scratch, self.random = program, scratch, random.Random(seed)

    def prepare(self):
        """A town, and the maps that are changed: in `before`, which is copied for each kill."""
        world, before = self.scratch / "town", self.scratch / "before"
        self.run("simulate", world, "--seed", 5, "--route_length_m", 120, "--width", 320, "--height", 240, "--sessions.lidar", "--sessions.forward2",
                 "--sim.changed", 0.3)
        before.mkdir()
        self.run("map", world / "forward", before / "half.xvm", "--frames", "0:30")
        shutil.copy(before / "half.xvm", before / "town.xvm")
        self.run("map", "--append", world / "forward", before / "town.xvm", "--frames", "30:45")
        for name, visit in (("fused.xvm", "rear"), ("visited.xvm", "forward2")):
            shutil.copy(before / "half.xvm", before / name)
            self.run("fuse", world / visit, before / name)
        return world

    def run(self, *arguments):
        done = subprocess.run([self.program, *map(str, arguments), "-q"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode:
            sys.exit(f"xview {' '.join(map(str, arguments))}: ended with {done.returncode}: {done.stderr}")

    def fresh(self):
        folder = self.scratch / "now"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.scratch / "before", folder)
        return folder

    def content(self, path):
        """A digest of a file or folder; none if it is not there. A map is opened, which undoes what a transaction left."""
        if not path.exists():
            return None
        if path.suffix == ".xvm":
            self.run("info", path)
            with contextlib.closing(sqlite3.connect(path)) as base:  # its rows, wherever they lie in the file
                return hashlib.sha256("\n".join(base.iterdump()).encode()).hexdigest()
        files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
        digest = hashlib.sha256()
        for file in files:
            digest.update(str(file.relative_to(path)).encode() + b"\0" + file.read_bytes())
        return digest.hexdigest()

    def whole_answers(self, path, every):
        """True if the file holds the first answers of `every`, none of them cut off."""
        left = self.answers(path)
        return left == every[: len(left)]

    @staticmethod
    def answers(path):
        """Without what differs from run to run."""
        return [{k: v for k, v in json.loads(line).items() if "_ms" not in k} for line in path.read_text().splitlines()]

    def kill(self, arguments, folder, length_s, after_first_part):
        process = subprocess.Popen([self.program, *(str(a).format(folder) for a in arguments), "-q"], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        began = time.monotonic()
        if after_first_part:
            while process.poll() is None and not any(self.beside(folder)):
                time.sleep(0.0005)
            wait = self.random.expovariate(1 / self.random.choice((0.001, 0.005, 0.02, 0.1)))
        else:
            wait = self.random.uniform(0, length_s)
        time.sleep(max(0, wait - (0 if after_first_part else time.monotonic() - began)))
        process.kill()
        return process.wait() == -9

    @staticmethod
    def beside(folder):
        return [p for p in folder.iterdir() if ".partial-" in p.name or p.name.endswith(("-journal", "-wal", "-shm"))]

    def row(self, name, arguments, output, count):
        folder = self.fresh()
        before = set(p.name for p in folder.iterdir())
        old = self.content(folder / output)
        whole = [str(a).format(folder) for a in arguments]
        began = time.monotonic()
        self.run(*whole)
        length_s = time.monotonic() - began
        # Answers hold times, so their text is not the same twice.
        every = self.answers(folder / output) if output.endswith(".jsonl") else None
        new = None if every else self.content(folder / output)
        if new and new == old:
            sys.exit(f"{name}: changes nothing")
        kills = dict.fromkeys(("hit", "writing", "old", "new", "part of the answers", "other", "left beside", "not made again"), 0)
        tries = 0
        while kills["hit"] < count:
            tries += 1
            if tries > 5 * count:
                sys.exit(f"{name}: ends before it is killed")
            folder = self.fresh()
            if not self.kill(arguments, folder, length_s, tries % 2):
                continue
            kills["hit"] += 1
            kills["writing"] += bool(self.beside(folder))
            path = folder / output
            if every and path.exists():
                kills["part of the answers" if self.whole_answers(path, every) else "other"] += 1
            else:
                left = self.content(path)
                kills["old" if left == old else "new" if left == new else "other"] += 1
            # What was made before it was killed is there: the command would be refused, or do more.
            again = self.fresh() if not every and old is not None and self.content(path) == new else folder
            self.run(*(str(a).format(again) for a in arguments))
            made = self.answers(path) == every if every else self.content(again / output) == new
            kills["not made again"] += not made
            beside = set(p.name for p in again.iterdir()) - before - {output}
            kills["left beside"] += bool(beside)
            if beside:
                print(f"{name}: beside lies {', '.join(beside)}", file=sys.stderr)
        print(f"{name}: {kills}", file=sys.stderr, flush=True)
        return [f"`{name}`" if "," not in name else f"`{name.split(',')[0]}`,{name.split(',', 1)[1]}", f"{length_s:.1f} s", *kills.values()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", nargs="?", type=int, default=10, help="kills of each command (default 10)")
    parser.add_argument("--program", default=ROOT / "build/xview", type=Path)
    parser.add_argument("--seed", default=1, type=int)
    parser.add_argument("--only", help="commands whose name begins so")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        killer = Killer(arguments.program.resolve(), Path(scratch), arguments.seed)
        world = killer.prepare()
        rows = [killer.row(*command, arguments.count) for command in commands(world)
                if not arguments.only or command[0].startswith(arguments.only)]
    total = ["all", "", *(sum(row[i] for row in rows) for i in range(2, len(rows[0])))]
    print(table([["command", "whole run", "killed", "of these while it wrote", "old or none", "new", "answers so far", "anything else",
                 "parts stayed after the next run", "next run made something else"], *rows, total]))
    sys.exit(any(total[i] for i in (7, 8, 9)))


if __name__ == "__main__":
    main()
