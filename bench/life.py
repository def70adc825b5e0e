#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes docs/results/life.md: whether maps find one another, what is said to have changed between two visits, what added drives leave.

Simulated towns and offices, two of five with lots or rooms that are copies, half of them with noisy depth, labels and odometry. In each a
fifth of the objects changes after the mapping drive. Halves and wholes of the other drives are joined to its map, and so are those of another
town and of the next world, which must be left out. Changes are told right if one of that class happened within 1 m. Visible are those whose
place (0.6 m above the foot, in offices 0.2 m) three images of each visit show, by their depths, from within 25 m (offices: 6 m). A visit that
is not found counts no changes. Drives of another day, and such that look back, are added to the maps of eight further towns, all of them noisy.
Worlds are kept in --work.
"""
import argparse
import csv
import datetime
import math
import shutil
import sqlite3
import struct
import sys
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
import fused_drives
from fused_drives import run
from paper_page import table, wrapped
from regress import simulated
from regress_poses import from_numbers, inverse
from results import with_interval

ROOT = Path(__file__).resolve().parent.parent
STYLES = ("suburb", "grid", "village", "office", "office")
VISIBLE_M = {"office": 6}
VISIBLE_OUTDOORS_M = 25
ABOVE_FOOT_M = {"office": 0.2}
ABOVE_FOOT_OUTDOORS_M = 0.6
BEHIND_M = 0.35  # a depth that is shorter by that hides a place
IMAGES = 3
WRONG_M = {"office": 0.5}
WRONG_OUTDOORS_M = 2
DRIVES = ("rear", "forward2", "elsewhere")
REJECTED = 3


def positions_in(folder):
    lines = (line.split() for line in (folder / "groundtruth.txt").read_text().splitlines())
    return [tuple(map(float, words[1:4])) for words in lines]


class DepthImage:
    """A PNG of 16 bits whose rows are stored as they are or as differences along the row, as `xview simulate` writes them."""

    def __init__(self, path):
        data, chunks, at = path.read_bytes(), {}, 8
        while at < len(data):
            size, name = struct.unpack(">I4s", data[at : at + 8])
            chunks[name] = chunks.get(name, b"") + data[at + 8 : at + 8 + size]
            at += 12 + size
        self.width, self.height = struct.unpack(">II", chunks[b"IHDR"][:8])
        self.rows, self.row_bytes = zlib.decompress(chunks[b"IDAT"]), 1 + 2 * self.width

    def at(self, u, v):
        row = self.rows[v * self.row_bytes : v * self.row_bytes + 3 + 2 * u]
        if row[0] > 1:
            raise ValueError(f"rows of filter {row[0]} are not read")
        first = 1 if row[0] == 1 else 1 + 2 * u
        high, low = row[first::2], row[first + 1 :: 2]
        return 256 * (sum(high) % 256) + sum(low) % 256


def seen_in(folder, places, reach_m):
    """How many images of a recording show each place."""
    camera = dict(line.split(": ") for line in (folder / "camera.yaml").read_text().splitlines() if ": " in line)
    fx, fy, cx, cy, scale = (float(camera[key]) for key in ("fx", "fy", "cx", "cy", "depth_scale"))
    seen = [0] * len(places)
    for number, line in enumerate((folder / "groundtruth.txt").read_text().splitlines()):
        T_camera_world = inverse(from_numbers(line.split()))
        image = None
        for i, place in enumerate(places):
            x, y, z = (sum(a * b for a, b in zip(row, (*place, 1))) for row in T_camera_world[:3])
            if not 0.3 < z < reach_m:
                continue
            image = image or DepthImage(folder / "depth" / f"{number:06d}.png")
            u, v = round(fx * x / z + cx), round(fy * y / z + cy)
            if 0 <= u < image.width and 0 <= v < image.height:
                seen[i] += image.at(u, v) * scale > z - BEHIND_M
    return seen


def cut(recording, first, last, part):
    """Some frames of a recording as one of its own."""
    if part.exists():
        return
    made = part.with_name(part.name + ".part")
    shutil.rmtree(made, ignore_errors=True)
    for images in ("depth", "label", "instance"):
        (made / images).mkdir(parents=True)
        for i in range(first, last):
            (made / images / f"{i - first:06d}.png").symlink_to(recording / images / f"{i:06d}.png")
    for name in ("camera.yaml", "classes.yaml"):
        shutil.copy(recording / name, made)
    (made / "poses.txt").write_text("".join((recording / "poses.txt").read_text().splitlines(True)[first:last]))
    made.rename(part)


class World:
    def __init__(self, program, work, number):
        self.style, self.noisy = STYLES[number % len(STYLES)], number % 2 == 1
        self.alike = number % len(STYLES) in (1, 4)
        flags = ["--seed", str(600 + number), "--sim.style", self.style, "--sim.changed", "0.2", "--sessions.forward2",
                 "--sessions.elsewhere", "--sessions.aerial=false", "--quality", "noisy" if self.noisy else "clean", "--threads", "1"]
        flags += [] if self.style == "office" else ["--route_length_m", "200"]
        flags += ["--sim.alike", "0.7"] if self.alike else []
        self.folder = simulated(program, work, f"life_{number}", flags)
        self.map = self.folder.with_suffix(".xvm")
        size = "room" if self.style == "office" else "town"
        done = run(program, "map", self.folder / "forward", self.map, "--size", size)
        if done.returncode != 0:
            sys.exit(done.stderr)
        self.parts = []  # (recording, its positions in the frame of forward, or None)
        for drive in DRIVES:
            truth = positions_in(self.folder / drive)
            for part, first, last in (("_0", 0, len(truth) // 2), ("_1", len(truth) // 2, len(truth)), ("", 0, len(truth))):
                if part:
                    cut(self.folder / drive, first, last, self.folder / (drive + part))
                self.parts.append((self.folder / (drive + part), None if drive == "elsewhere" else truth[first:last]))

    def kind(self):
        return ("office" if self.style == "office" else "town") + (" of copies" if self.alike else "") + (", noisy" if self.noisy else ", clean")


def joined(program, first, second, truth, scratch):
    """How far key frames lie from the truth, median; infinite for a stranger; nothing if it was left out."""
    scratch.unlink(missing_ok=True)
    done = run(program, "map", "--join", first, second, scratch)
    if done.returncode == REJECTED:
        return None
    if done.returncode != 0:
        sys.exit(done.stderr)
    if truth is None:
        return math.inf
    with sqlite3.connect(scratch) as base:
        rows = base.execute("SELECT number, x, y, z FROM keyframes WHERE source > 0").fetchall()
    errors = sorted(math.dist(truth[number], at) for number, *at in rows)
    return errors[len(errors) // 2]


def changes_in(path):
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            if row.get("dynamic") == "1":
                continue
            at, to = ([float(row[p + c]) for c in "xyz"] if row[p + "x"] else None for p in ("", "to_"))
            if row["change"] != "new":
                yield "gone", row["class"], at
            yield from [("new", row["class"], to or at)] if row["change"] != "gone" else []


def told(program, world, drive, scratch):
    """How many changes were told, of these right; how many were visible, of these told. Nothing if the visit was not found."""
    done = run(program, "diff", world.map, world.folder / drive, "-o", scratch)
    if done.returncode == REJECTED:
        return None
    if done.returncode != 0:
        sys.exit(done.stderr)
    truth, said = list(changes_in(world.folder / "changes.csv")), list(changes_in(scratch))
    meet = lambda a, b: a[:2] == b[:2] and math.dist(a[2][:2], b[2][:2]) < 1
    above_m = ABOVE_FOOT_M.get(world.style, ABOVE_FOOT_OUTDOORS_M)
    places = [(x, y, z + above_m) for _, _, (x, y, z) in truth]
    shown = [seen_in(world.folder / d, places, VISIBLE_M.get(world.style, VISIBLE_OUTDOORS_M)) for d in ("forward", drive)]
    seen = [change for change, *images in zip(truth, *shown) if min(images) >= IMAGES]
    return (len(said), sum(any(meet(a, b) for b in truth) for a in said), len(seen),
            sum(any(meet(a, b) for b in said) for a in seen))


def measure(program, work, count):
    with ThreadPoolExecutor(2) as pool:
        worlds = list(pool.map(lambda number: World(program, work, number), range(count)))

        def of_world(number):
            world, following = worlds[number], worlds[(number + 1) % count]
            scratch = work / f"scratch_{number}"
            parts = world.parts + [(part, None) for part, _ in following.parts[:3]]
            pairs = [(truth is not None, joined(program, world.map, part, truth, scratch.with_suffix(".xvm")))
                     for part, truth in parts]
            print(world.kind(), pairs, file=sys.stderr, flush=True)
            return world, pairs, [told(program, world, drive, scratch.with_suffix(".csv")) for drive in ("forward2", "rear")]

        return list(pool.map(of_world, range(count)))


def rows_of(measured):
    joins, changes = [], []
    for kind in sorted({world.kind() for world, *_ in measured}):
        here = [m for m in measured if m[0].kind() == kind]
        wrong_m = WRONG_M.get(here[0][0].style, WRONG_OUTDOORS_M)
        pairs = [p for _, found, _ in here for p in found]
        true = [error for is_true, error in pairs if is_true]
        right = sorted(e for e in true if e is not None and e <= wrong_m)
        strangers = [error for is_true, error in pairs if not is_true]
        joins.append([kind, str(len(true)), with_interval(len(right), len(true)), f"{right[len(right) // 2]:.2f}" if right else "-",
                      str(sum(e is not None and e > wrong_m for e in true)),
                      f"{sum(e is not None for e in strangers)} of {len(strangers)}"])
        visits = [visit for _, _, of_world in here for visit in of_world]
        said, right, seen, found = (sum(visit[i] for visit in visits if visit) for i in range(4))
        changes.append([kind, f"{sum(visit is not None for visit in visits)} of {len(visits)}", str(said), with_interval(right, said) if said else "-", str(seen), with_interval(found, seen) if seen else "-"])
    return joins, changes


def page(joins, changes, added, ten):
    return f"""# The life of a map

Written by `./run life` on {datetime.date.today()}; do not edit. {" ".join(__doc__.split(chr(10) * 2)[1].split())}

## Maps without a common frame: `map --join`

{table([["worlds", "pairs that overlap", "joined where they belong, %", "median error, m", "elsewhere", "joined of pairs that share nothing"], *joins])}

## What changed: `diff`

{table([["worlds", "visits found", "told", "of these right, %", "visible", "of these told, %"], *changes])}

## Drives that are added: `fuse`

Points {fused_drives.AROUND_M} m around each frame that was added, against where the truth has them. *Drift*: error of the odometry of the added
drive per distance; the map has stereo noise and none.

{table([["drift", "drives found", "points off, m, median", "nine of ten less than"], *added])}

Ten drives one after the other: every fifth frame of two, so no frame comes twice. Thickness: twice the standard deviation across pieces of
walls of {fused_drives.CELL_M:g} m, median; *by the truth*: the same frames appended at their true poses; *beyond that*: what fused walls are
thicker by. Queries: windows of the way back. *Undone*: ten times `fuse --undo` gave the file of before, but for bytes in which SQLite counts.

{table([["drift", "added", "pieces of walls", "thickness before, cm", "after, cm", "by the truth, cm", "beyond that, cm, median", "nine of ten less than", "accepted before", "accepted after", "undone"], *ten])}
"""


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--program", type=Path, default=ROOT / "build/xview")
    arguments.add_argument("--work", type=Path, default=Path("build/life"), help="folder for worlds and maps")
    arguments.add_argument("--worlds", type=int, default=16)
    arguments.add_argument("--fused", type=int, default=8, help="towns to which drives are added")
    arguments.add_argument("--page", type=Path, default=ROOT / "docs/results/life.md")
    given = arguments.parse_args()
    (given.work / "worlds").mkdir(parents=True, exist_ok=True)
    program, work = given.program.resolve(), given.work.resolve()
    with ThreadPoolExecutor(2) as pool:
        fused = list(pool.map(lambda number: fused_drives.measure(program, work, number), range(given.fused)))
    measured = page(*rows_of(measure(program, work, given.worlds)), *fused_drives.rows_of(fused))
    given.page.write_text(wrapped(measured))


if __name__ == "__main__":
    main()
