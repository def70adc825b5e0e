#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Clouds with odd numbers: does a point that belongs to no place change, delay or falsify an answer of `xview localize`?

Each of COUNT clouds is an honest query with stray points, points that are no numbers, repeats of zero, and another zero of its
coordinates: lifted, moved as far as national coordinates lie, turned by half a turn. The truth is the honest answer, moved
accordingly. Counts hangs (over --limit seconds), false positions (accepted, and more than 5 m from the truth, in rooms 0.5 m, at the
middle of the cloud or at the position that is reported), and answers as without: the same status, and the middle of the cloud within
the stated sigma or 0.1 m. Exit code 1 if a cloud hangs or is false, or fewer than 98 % are as without.
"""
import argparse
import array
import collections
import json
import math
import random
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table
from regress_poses import from_numbers, inverse, product, turned_about_z

ROOT = Path(__file__).resolve().parent.parent
COUNTS = (1, 5, 30, 100, 300, 1000)
SIZES = (5e3, 1e5, 1e6, 1e7, 1e9, 1e10, 1e12, 1e30, 1e300)
ZEROS = (0.1, 0.3, 0.6)
HEIGHTS_M = (200, 500, 1000)
UTM = (431000.0, 4582000.0)
TYPES = {b"float": ("f", 4), b"double": ("d", 8), b"uint": ("I", 4), b"int": ("i", 4), b"uchar": ("B", 1), b"ushort": ("H", 2)}


class Base:
    """An honest query, the map that it lies in, and how far off a false position is."""

    def __init__(self, name, cloud, place, tolerance_m):
        self.name, self.map, self.tolerance_m = name, place, tolerance_m
        self.comments, self.points, self.labels = read_ply(cloud)
        middle = [sorted(axis)[len(axis) // 2] for axis in zip(*self.points)]
        self.middle = middle + [1.0]


def read_ply(path):
    """Comments, positions and labels (or None) of a binary PLY of xview, or one with x, y and z."""
    data = path.read_bytes()
    head, _, body = data.partition(b"end_header\n")
    lines = head.split(b"\n")
    rows = next(int(line.split()[2]) for line in lines if line.startswith(b"element vertex"))
    fields = [(line.split()[2], *TYPES[line.split()[1]]) for line in lines if line.startswith(b"property")]
    row = struct.Struct("<" + "".join(code for _, code, _ in fields))
    names = [name for name, _, _ in fields]
    at = [names.index(name) for name in (b"x", b"y", b"z")]
    label = names.index(b"label") if b"label" in names else None
    values = list(row.iter_unpack(body[: rows * row.size]))
    points = [tuple(v[i] for i in at) for v in values]
    comments = b"".join(line + b"\n" for line in lines if line.startswith(b"comment"))
    return comments, points, None if label is None else [v[label] for v in values]


def write_cloud(path, base, points, labels):
    """As PCD or PLY in double precision, or as a scan in single precision, which has no labels."""
    if path.suffix == ".bin":
        with path.open("wb") as file:
            array.array("f", [f for p in points for f in (*map(single, p), 0.0)]).tofile(file)
        return
    row = struct.Struct("<dddI" if labels else "<ddd")
    rows = b"".join(row.pack(*p, label) for p, label in zip(points, labels)) if labels else b"".join(row.pack(*p) for p in points)
    if path.suffix == ".ply":
        head = b"ply\nformat binary_little_endian 1.0\n" + base.comments + b"element vertex %d\n" % len(points)
        head += b"".join(b"property double %s\n" % axis for axis in (b"x", b"y", b"z"))
        head += (b"property uint label\n" if labels else b"") + b"end_header\n"
    else:
        head = b"# .PCD v0.7\n" + base.comments.replace(b"comment ", b"# ") + b"VERSION 0.7\n"
        names = [b"x", b"y", b"z"] + [b"label"] * bool(labels)
        head += b"FIELDS %s\nSIZE %s\nTYPE %s\nCOUNT %s\n" % tuple(
            b" ".join(words) for words in (names, [b"8"] * 3 + [b"4"] * bool(labels), [b"F"] * 3 + [b"U"] * bool(labels), [b"1"] * len(names)))
        head += b"WIDTH %d\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS %d\nDATA binary\n" % (len(points), len(points))
    path.write_bytes(head + rows)


def single(value):
    return value if abs(value) < 3e38 or value != value else math.copysign(3e38, value)


def moved(T, points):
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = T[:3]
    return [(a * p + b * q + c * r + x, d * p + e * q + f * r + y, g * p + h * q + i * r + z) for p, q, r in points]


def odd(base, rng, is_scan):
    """Kind of strays, what is done to a cloud in words, how it is moved, its points and labels. A scan has its scanner at zero."""
    move, words = turned_about_z(0), []
    if rng.random() < 0.25:
        move, words = turned_about_z(math.pi), words + ["turned"]
    if rng.random() < 0.4 and not is_scan:
        move[2][3] = float(rng.choice(HEIGHTS_M))
        words.append(f"lifted {move[2][3]:g} m")
    if rng.random() < 0.5 and not is_scan:
        move[0][3], move[1][3] = UTM
        words.append("UTM")
    points, labels = moved(move, base.points), base.labels and list(base.labels)
    kind = rng.choice(("near", "zero", "far", "far", "mixed", "nan", "zeros", "none"))
    count = rng.choice(COUNTS)
    if kind == "zeros":
        share = rng.choice(ZEROS)
        count, strays = 0, [(0.0, 0.0, 0.0)] * int(share / (1 - share) * len(points))
        words.append(f"{share:.0%} zeros")
    elif kind == "zero":
        strays = [(0.0, 0.0, 0.0)] * count
    elif kind == "nan":
        strays = [tuple(rng.choice((math.nan, math.inf, -math.inf, 1.0)) for _ in range(2)) + (math.nan,) for _ in range(count)]
    elif kind == "none":
        count, strays = 0, []
    else:
        size = {"near": lambda: 5e3, "far": lambda s=rng.choice(SIZES): s, "mixed": lambda: rng.choice(SIZES)}[kind]
        middle = moved(move, [tuple(base.middle[:3])])[0]
        strays = [tuple(m + rng.choice((-1, 1)) * size() * rng.uniform(0.5, 1) for m in middle) for _ in range(count)]
    if count:
        words.append(f"{count} {kind}")
    first = rng.choice(("first", "middle", "last"))
    at = {"first": 0, "middle": len(points) // 2, "last": len(points)}[first]
    points[at:at] = strays
    if labels:
        labels[at:at] = [rng.choice(base.labels) for _ in strays]
    return kind, ", ".join(words + [first] * bool(strays)), move, points, labels


def answer(program, cloud, place, limit_s):
    """The answer as JSON; a word if there is none."""
    command = [str(program), "localize", str(cloud), str(place), "--json", "-q", "--threads", "1"]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=limit_s)
    except subprocess.TimeoutExpired:
        return "hang"
    if run.returncode not in (0, 3):
        return "error: " + run.stderr.strip()
    return json.loads(run.stdout)


def image(T, p):
    return [sum(T[row][i] * p[i] for i in range(4)) for row in range(3)]


def judged(base, truth, move, honest, got):
    """What an answer is, and how far off it is [m]."""
    if got == "hang":
        return "hang", math.nan
    if isinstance(got, str):
        return "error", math.nan
    if not got["T_map_query"]:
        return "other", math.nan
    middle = image(move, base.middle) + [1.0]
    T = from_numbers(got["T_map_query"])
    off_m = math.dist(image(T, middle), image(truth, middle))
    if got["status"] == "accepted":
        position = got["pose"]["position"]
        reported_m = math.dist(position, image(truth, image(inverse(T), position + [1.0]) + [1.0]))
        if max(off_m, reported_m) > base.tolerance_m:
            return "false", max(off_m, reported_m)
    if got["status"] != honest["status"]:
        return "other", off_m
    sigma_m = got["statistics"]["sigma_m"]
    return ("as without" if off_m <= max(0.1, sigma_m) else "other"), off_m


def bases(program, data, scratch):
    def run(*arguments):
        subprocess.run([str(program), *map(str, arguments), "-q"], check=True, stdout=subprocess.DEVNULL)

    def query(name, folder, frames, voxel_m, place, tolerance_m):
        run("lift", data / folder, scratch / f"{name}.ply", "--voxel", voxel_m, *(("--frames", frames) if frames else ()))
        run("map", data / place, scratch / f"{name}.xvm")
        return Base(name, scratch / f"{name}.ply", scratch / f"{name}.xvm", tolerance_m)

    yield query("suburb", "suburb_clean/rear", "0:30", 0.3, "suburb_clean/forward", 5)
    yield query("kitti", "kitti00/query_4501", None, 0.2, "kitti00/map", 5)
    yield query("office", "office_noisy/forward", "100:140", 0.08, "office_noisy/forward", 0.5)
    run("map", data / "registration/target.ply", scratch / "pair.xvm")
    yield Base("pair", data / "registration/source.ply", scratch / "pair.xvm", 5)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "build/xview")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared/data")
    parser.add_argument("--count", type=int, default=300, help="clouds")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60, help="of a query [s]")
    parser.add_argument("--keep", type=Path, help="folder for clouds that hang, are false or are other than without")
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    counts = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        honest = []
        for base in bases(arguments.program, arguments.data, scratch):
            for suffix in (".pcd", ".ply") + ((".bin",) if base.labels is None else ()):
                write_cloud(scratch / f"honest{suffix}", base, base.points, base.labels)
                clean = answer(arguments.program, scratch / f"honest{suffix}", base.map, arguments.limit)
                print(f"{base.name}{suffix}: {len(base.points)} points, {clean if isinstance(clean, str) else clean['status']}", flush=True)
                honest.append((base, suffix, clean))
        for i in range(arguments.count):
            base, suffix, clean = honest[i % len(honest)]
            kind, words, move, points, labels = odd(base, rng, suffix == ".bin")
            cloud = scratch / f"odd{suffix}"
            write_cloud(cloud, base, points, labels)
            truth = product(from_numbers(clean["T_map_query"]), inverse(move))
            got = answer(arguments.program, cloud, base.map, arguments.limit)
            verdict, off_m = judged(base, truth, move, clean, got)
            counts[kind, verdict] += 1
            if verdict == "as without":
                continue
            why = got if isinstance(got, str) else f"{got['status']}, {off_m:.3g} m off: {got['reason']}"
            print(f"{i} {base.name}{suffix}, {words}: {verdict}, {why}", flush=True)
            if arguments.keep:
                arguments.keep.mkdir(parents=True, exist_ok=True)
                cloud.replace(arguments.keep / f"{i}{suffix}")
    verdicts = ("as without", "other", "error", "false", "hang")
    kinds = sorted({kind for kind, _ in counts})
    rows = [[kind] + [counts[kind, verdict] for verdict in verdicts] for kind in kinds]
    rows.append(["all"] + [sum(counts[kind, verdict] for kind in kinds) for verdict in verdicts])
    print("\n" + table([["strays", *verdicts]] + rows))
    as_without, _, _, false, hangs = rows[-1][1:]
    sys.exit(bool(false or hangs or as_without < 0.98 * arguments.count))


if __name__ == "__main__":
    main()
