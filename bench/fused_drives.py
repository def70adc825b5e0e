# SPDX-License-Identifier: BSD-3-Clause
"""What drives that are added to a map by `xview fuse` leave in it: for bench/life.py."""
import json
import math
import shutil
import sqlite3
import struct
import subprocess
import sys
from collections import defaultdict, namedtuple

from regress import simulated
from regress_poses import from_numbers, inverse, product
from regress_worlds import matrices_in

STYLES = ("suburb", "village", "campus", "grid")
DRIFTS = (0.01, 0.03)
TEN = [(drive, first) for first in range(5) for drive in ("forward2", "rear")]  # every fifth frame of two drives, in turn
AROUND_M = 15  # points of a frame are so far from it
CELL_M, FEW, WIDE_M, FLAT = 2.0, 15, 0.4, 0.5  # a piece of a wall: side, points, least spread along it, most of that across it
WINDOW = 15  # frames of a query
RIGHT_M = 2
ADDED = ("forward2", "rear")
COUNTERS = 12  # bytes of a file in which SQLite counts its changes
Fused = namedtuple("Fused", "drift drives found errors ten walls found_before found_after is_undone")


def run(program, *arguments):
    return subprocess.run([str(program), *map(str, arguments), "--threads", "1", "-q"], capture_output=True, text=True)


def checked(program, *arguments):
    done = run(program, *arguments)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, arguments))}: ended with {done.returncode}: {done.stderr}")


def truth_of(folder):
    return matrices_in(folder / "groundtruth.txt")


def errors_of(map_path, truth):
    """How far points around each frame that was added lie from where the truth has them [m]."""
    with sqlite3.connect(map_path) as base:
        rows = base.execute("SELECT number, r00, r01, r02, x, r10, r11, r12, y, r20, r21, r22, z FROM keyframes WHERE source > 0").fetchall()
    errors = []
    for number, *pose in rows:
        moved = product(from_numbers(pose), inverse(truth[number]))
        x, y, z = (truth[number][i][3] for i in range(3))
        for k in range(8):
            angle = math.pi * k / 4
            point = x + AROUND_M * math.cos(angle), y + AROUND_M * math.sin(angle), z
            errors.append(math.dist(point, [sum(a * b for a, b in zip(row, (*point, 1))) for row in moved[:3]]))
    return errors


def building_points(program, map_path, cloud):
    """Those of buildings that the map keeps."""
    checked(program, "lift", map_path, cloud)
    with sqlite3.connect(map_path) as base:
        (building,) = base.execute("SELECT id FROM labels WHERE name = 'building'").fetchone()
    data = cloud.read_bytes()
    begin = data.index(b"\n", data.index(b"\nDATA ") + 1) + 1
    head = dict(line.split(" ", 1) for line in data[:begin].decode().splitlines() if " " in line)
    if head["DATA"] != "binary":
        raise ValueError(f"points that are {head['DATA']} are not read")
    names = head["FIELDS"].split()
    codes = {"F4": "f", "U4": "I", "I4": "i", "U2": "H", "U1": "B"}
    row = struct.Struct("<" + "".join(codes[kind + size] for kind, size in zip(head["TYPE"].split(), head["SIZE"].split())))
    x, label = names.index("x"), names.index("label")
    end = begin + row.size * int(head["POINTS"])
    return [p[x : x + 3] for p in row.iter_unpack(data[begin:end]) if p[label] == building]


def spreads(points):
    """Standard deviations along the principal axes [m], the least first."""
    n = len(points)
    mean = [sum(p[i] for p in points) / n for i in range(3)]
    C = [[sum((p[i] - mean[i]) * (p[j] - mean[j]) for p in points) / n for j in range(3)] for i in range(3)]
    # Eigenvalues of a symmetric matrix of 3 rows (Smith 1961).
    q = (C[0][0] + C[1][1] + C[2][2]) / 3
    off = C[0][1] ** 2 + C[0][2] ** 2 + C[1][2] ** 2
    p = math.sqrt((sum((C[i][i] - q) ** 2 for i in range(3)) + 2 * off) / 6) or 1e-12
    B = [[(C[i][j] - (q if i == j else 0)) / p for j in range(3)] for i in range(3)]
    det = (B[0][0] * (B[1][1] * B[2][2] - B[1][2] * B[2][1]) - B[0][1] * (B[1][0] * B[2][2] - B[1][2] * B[2][0])
           + B[0][2] * (B[1][0] * B[2][1] - B[1][1] * B[2][0]))
    angle = math.acos(max(-1.0, min(1.0, det / 2))) / 3
    values = sorted(q + 2 * p * math.cos(angle + 2 * math.pi * k / 3) for k in range(3))
    return [math.sqrt(max(0.0, v)) for v in values]


def thickness(points):
    """Of each piece of a wall [m], by cell: twice the standard deviation across it."""
    cells = defaultdict(list)
    for point in points:
        cells[tuple(math.floor(v / CELL_M) for v in point)].append(point)
    found = {}
    for cell, inside in cells.items():
        if len(inside) < FEW:
            continue
        across, along, _ = spreads(inside)
        if along > WIDE_M and across < FLAT * along:
            found[cell] = 2 * across
    return found


def right_in(program, drive, map_path):
    """Windows of a drive whose accepted pose is right, those whose accepted pose is wrong, and all."""
    truth, right, wrong, asked = truth_of(drive), 0, 0, 0
    for line in run(program, "localize", drive, map_path, "--window", WINDOW, "--stride", WINDOW // 2, "--json").stdout.splitlines():
        answer = json.loads(line)
        asked += 1
        if answer["status"] == "accepted":
            there = [row[3] for row in truth[answer["query"]["last_index"]][:3]]
            is_right = math.dist(there, answer["pose"]["position"]) < RIGHT_M
            right, wrong = right + is_right, wrong + (not is_right)
    return right, wrong, asked


def true_drive(drive):
    """The same recording, its poses by the truth."""
    made = drive.with_name(drive.name + "_true")
    if not made.exists():
        part = made.with_name(made.name + ".part")
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir()
        for entry in drive.iterdir():
            if entry.name != "poses.txt":
                (part / entry.name).symlink_to(entry)
        shutil.copy(drive / "groundtruth.txt", part / "poses.txt")
        part.rename(made)
    return made


def measure(program, work, number):
    drift, style = DRIFTS[number % len(DRIFTS)], STYLES[number // len(DRIFTS) % len(STYLES)]
    flags = ["--seed", str(700 + number), "--sim.style", style, "--quality", "noisy", "--drift", str(drift), "--route_length_m", "200",
             "--sessions.forward2", "--sessions.reverse", "--sessions.aerial=false", "--threads", "1"]
    world = simulated(program, work, f"fuse_{number}", flags)
    original, grown, by_truth, cloud = (work / f"fuse_{number}{ending}" for ending in (".xvm", "_grown.xvm", "_truth.xvm", ".pcd"))
    checked(program, "map", world / "forward", original)
    errors = []
    for drive in ADDED:
        shutil.copy(original, grown)
        if run(program, "fuse", world / drive, grown).returncode == 0:
            errors.append(errors_of(grown, truth_of(world / drive)))
    shutil.copy(original, grown)
    shutil.copy(original, by_truth)
    ten = 0
    for drive, first in TEN:
        frames = f"{first}:{len(truth_of(world / drive))}:5"
        if run(program, "fuse", world / drive, grown, "--frames", frames, "--force").returncode == 0:
            ten += 1
            checked(program, "map", "--append", true_drive(world / drive), by_truth, "--frames", frames, "--force")
    before, after, true = (thickness(building_points(program, path, cloud)) for path in (original, grown, by_truth))
    walls = [(before[cell], after[cell], true[cell]) for cell in sorted(before.keys() & after.keys() & true.keys())]
    found = [right_in(program, world / "reverse", path) for path in (original, grown)]
    for _ in range(ten):
        checked(program, "fuse", "--undo", grown)
    is_undone = sum(a != b for a, b in zip(grown.read_bytes(), original.read_bytes())) <= COUNTERS
    is_undone &= grown.stat().st_size == original.stat().st_size
    print("fuse", style, drift, [round(median(e), 3) for e in errors], ten, len(walls), found, is_undone, file=sys.stderr, flush=True)
    return Fused(drift, len(ADDED), len(errors), sum(errors, []), ten, walls, *found, is_undone)


def rows_of(measured):
    added, ten = [], []
    for drift in sorted({m.drift for m in measured}):
        here = [m for m in measured if m.drift == drift]
        errors = sorted(e for m in here for e in m.errors)
        walls = [wall for m in here for wall in m.walls]
        beyond = [wall[1] - wall[2] for wall in walls]
        before, after = ([sum(getattr(m, when)[i] for m in here) for i in range(3)] for when in ("found_before", "found_after"))
        added.append([f"{100 * drift:g} %", f"{sum(m.found for m in here)} of {sum(m.drives for m in here)}",
                      *(f"{quantile(errors, q):.2f}" for q in (0.5, 0.9))])
        ten.append([f"{100 * drift:g} %", f"{sum(m.ten for m in here)} of {len(TEN) * len(here)}", str(len(walls)),
                    *(f"{100 * median(wall[i] for wall in walls):.0f}" for i in range(3)),
                    *(f"{100 * quantile(beyond, q):.1f}" for q in (0.5, 0.9)),
                    *(f"{right} of {asked}, {wrong} wrong" for right, wrong, asked in (before, after)),
                    f"{sum(m.is_undone for m in here)} of {len(here)}"])
    return added, ten


def quantile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))] if values else math.nan


def median(values):
    return quantile(values, 0.5)
