#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Recordings whose odometry is wrong: is a pose accepted that the last frame contradicts, does a map take what is
contradicted?

    bench/odometry_faults.py [--data ../shared/data] [--xview build/xview] [--windows 600] [--what localize,fuse,...]
                             [--worlds oldtown_5:rear,oblique:30 warehouse_5:rear:40:room]

Poses of honest recordings are changed (jumps, stale, shifted and reversed poses, errors of length, heading and roll); images
stay as they are. Counts accepted answers whose last pose is more than 5 m (rooms: 0.5 m) off, key frames that `fuse` puts
more than 2 m (0.5 m) off, poses of --trajectory, --track, --sequence and follow that are off, and with --what honest
recordings without a fault in which `info` finds one. Exit code 1 if there are any.
"""
import argparse
import collections
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile

import numpy as np

ROOMS = {"office_noisy"}
WORLDS = {  # recordings that are asked, frames of a window
    "suburb_clean": (["rear", "forward2", "oblique"], 30),
    "suburb_noisy": (["rear", "forward2"], 30),
    "grid_noisy": (["rear"], 50),
    "village_poor": (["rear", "oblique"], 40),
    "office_noisy": (["rear", "other"], 50),
}


def read_poses(path):
    """Stamps and poses of a TUM file; no stamps of one with 12 numbers a line."""
    rows = [line.split() for line in open(path) if line.strip() and not line.startswith("#")]
    if rows and len(rows[0]) == 12:
        return None, [np.vstack([np.array(row, float).reshape(3, 4), [0, 0, 0, 1]]) for row in rows]
    stamps, poses = [], []
    for row in rows:
        s, x, y, z, qx, qy, qz, qw = map(float, row)
        n = np.array([qx, qy, qz, qw])
        qx, qy, qz, qw = n / np.linalg.norm(n)
        T = np.eye(4)
        T[:3, :3] = [[1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw)],
                     [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw)],
                     [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy)]]
        T[:3, 3] = x, y, z
        stamps.append(s)
        poses.append(T)
    return stamps, poses


def quaternion(R):
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
                  [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R.trace()]]) / 3
    q = np.linalg.eigh(K)[1][:, -1]
    return q * np.sign(q[3] or 1)


def lines(stamps, poses):
    if stamps is None:
        return "".join(" ".join("%.9g" % v for v in T[:3].ravel()) + "\n" for T in poses)
    return "".join("%.6f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n" % (s, *T[:3, 3], *quaternion(T[:3, :3]))
                   for s, T in zip(stamps, poses))


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    R = {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis]
    T = np.eye(4)
    T[:3, :3] = R
    return T


def jumped(poses, at, shift, yaw=0.0):
    """All poses from `at` on are moved, as a front end does that closes a loop."""
    centre = poses[at][:3, 3] if at < len(poses) else np.zeros(3)
    move = turn("z", yaw)
    move[:3, 3] = centre - move[:3, :3] @ centre + shift
    return [move @ T if i >= at else T for i, T in enumerate(poses)]


def drifted(poses, length=0.0, yaw_per_m=0.0, roll_per_m=0.0):
    out = [poses[0]]
    for a, b in zip(poses, poses[1:]):
        step = np.linalg.inv(a) @ b
        way = np.linalg.norm(step[:3, 3])
        step = step.copy()
        step[:3, 3] *= 1 + length
        T = out[-1] @ step
        for axis, rate in (("z", yaw_per_m), ("x", roll_per_m)):
            T[:3, :3] = turn(axis, rate * way)[:3, :3] @ T[:3, :3]
        out.append(T)
    return out


def moved_by(poses, at, metres, direction):
    return jumped(poses, at, metres * np.array([np.cos(direction), np.sin(direction), 0]))


def faults(unit, first, last, rng):
    """(name, function of all poses): `unit` is 1 in towns and 0.1 in rooms; [first, last) is the window."""
    for metres in (8, 18, 40):
        for before in (1, 2, 4, 8, 12, (last - first) // 2):
            d = rng.uniform(-np.pi, np.pi)
            yield (f"jump {metres * unit:g} m, {before} frames before the end",
                   lambda T, m=metres, b=before, d=d: moved_by(T, last - b, m * unit, d))
    d = rng.uniform(-np.pi, np.pi)
    yield "jump and turn", lambda T, d=d: jumped(
        T, last - 6, 12 * unit * np.array([np.cos(d), np.sin(d), 0]), np.radians(40))
    for degrees in (20, 40, 80):
        for before in (2, 6, 12):
            yield (f"turn {degrees} deg, {before} frames before the end",
                   lambda T, a=np.radians(degrees), b=before: jumped(T, last - b, np.zeros(3), a))
    for k in (4, 7, 10, 20):
        yield f"stands still for the last {k} frames", lambda T, k=k: [
            T[min(i, last - k)] if i < last else T[i] for i in range(len(T))]
    yield "every second pose stale", lambda T: [T[i // 2 * 2] for i in range(len(T))]
    yield "shifted by 3 frames", lambda T: T[3:] + [T[-1]] * 3
    yield "reversed", lambda T: T[:first] + T[first:last][::-1] + T[last:]
    for share in (-0.1, -0.05, 0.05, 0.1):
        yield f"length {share:+.0%}", lambda T, s=share: drifted(T, s)
    for rate in (0.5, 2):
        yield f"heading {rate} deg/m", lambda T, r=rate: drifted(T, 0, np.radians(r / unit ** 0.5))
    for rate in (0.2, 0.7, 1, 1.4):
        yield f"roll {rate} deg/m", lambda T, r=rate: drifted(T, 0, 0, np.radians(r / unit ** 0.5))


class Trials:
    def __init__(self, args):
        self.args = args
        self.folder = tempfile.mkdtemp(prefix="xview_odometry_")
        self.counts = collections.defaultdict(collections.Counter)
        self.wrong = 0

    def run(self, *words):
        return subprocess.run([self.args.xview, *map(str, words), "--threads", "1"], capture_output=True, text=True)

    def map_of(self, world):
        path = f"{self.folder}/{world}.xvm"
        if not os.path.exists(path):
            self.run("map", f"{self.args.data}/{world}/forward", path, "-q")
        return path

    def changed(self, source, text):
        folder = f"{self.folder}/query"
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        for name in os.listdir(source):
            if name not in ("poses.txt", "groundtruth.txt"):
                os.symlink(os.path.abspath(f"{source}/{name}"), f"{folder}/{name}")
        with open(f"{folder}/poses.txt", "w") as out:
            out.write(text)
        return folder

    def note(self, what, kind, result, detail=""):
        self.counts[what, kind][result] += 1
        if result == "WRONG":
            self.wrong += 1
            print(f"!! {what}, {kind}: {detail}", flush=True)

    def judge(self, world, what, kind, answer, truth):
        tolerance = 0.5 if world in ROOMS else 5
        if answer["status"] != "accepted":
            return self.note(what, kind, "refused")
        off = np.linalg.norm(np.array(answer["pose"]["position"]) - truth[answer["query"]["last_frame"]][:3, 3])
        self.note(what, kind, "right" if off <= tolerance else "WRONG",
                  f"{world} {answer['query']['first_frame']}-{answer['query']['last_frame']}: {off:.1f} m off, "
                  f"p_wrong {answer['p_wrong']:.2g}")

    def localize(self):
        done = 0
        rng = np.random.default_rng(self.args.seed)
        while done < self.args.windows:
            for world, (sessions, size) in WORLDS.items():
                for session in sessions:
                    source = f"{self.args.data}/{world}/{session}"
                    stamps, poses = read_poses(f"{source}/poses.txt")
                    truth = read_poses(f"{source}/groundtruth.txt")[1]
                    first = int(rng.integers(0, len(poses) - size + 1))
                    unit = 0.1 if world in ROOMS else 1
                    cases = [("honest", lambda T: T), *(
                        c for c in faults(unit, first, first + size, rng) if self.args.only in c[0])]
                    tried = min(self.args.per_window, len(cases) - 1)
                    chosen = [0, *sorted(rng.choice(np.arange(1, len(cases)), tried, replace=False))]
                    for i in chosen:
                        kind, change = cases[i]
                        folder = self.changed(source, lines(stamps, change(poses)))
                        out = self.run("localize", folder, self.map_of(world), "--frames", f"{first}:{first + size}",
                                       "--json", "-q")
                        if not out.stdout:
                            self.note("localize", kind, "error")
                            continue
                        self.judge(world, "localize", kind, json.loads(out.stdout.splitlines()[0]), truth)
                        done += i > 0

    def honest(self):
        """Recordings as they are: `info` must not say that their odometry jumps."""
        for world, (sessions, _) in WORLDS.items():
            for session in ["forward", *sessions]:
                folder = f"{self.args.data}/{world}/{session}"
                if os.path.isdir(folder):
                    said = "nothing in the scans contradicts it" in self.run("info", folder).stdout
                    self.note("info", "honest", "right" if said else "WRONG", f"{world} {session} is said to jump")

    def recordings(self):
        """Whole recordings with one fault: (world, name, folder, truth)."""
        rng = np.random.default_rng(self.args.seed + 1)
        drives = (("suburb_clean", "rear"), ("suburb_clean", "forward2"), ("suburb_noisy", "rear"),
                  ("office_noisy", "other"), ("office_noisy", "rear"))
        for world, session in drives if not self.args.worlds else [(w, s) for w in WORLDS for s in WORLDS[w][0]]:
            source = f"{self.args.data}/{world}/{session}"
            stamps, poses = read_poses(f"{source}/poses.txt")
            truth = read_poses(f"{source}/groundtruth.txt")[1]
            unit = 0.1 if world in ROOMS else 1
            cases = [("honest", lambda T: T)]
            for at in (len(poses) // 2 - 8, len(poses) - 6):
                for metres in (8, 18, 40):
                    d = rng.uniform(-np.pi, np.pi)
                    cases.append((f"jump {metres * unit:g} m", lambda T, a=at, m=metres, d=d: moved_by(T, a, m * unit, d)))
            middle = len(poses) // 2
            cases += [("length +10 %", lambda T: drifted(T, 0.1)), ("length -10 %", lambda T: drifted(T, -0.1)),
                      ("stuck", lambda T: T[:middle] + [T[middle]] * (len(T) - middle)),
                      ("every second pose stale", lambda T: [T[i // 2 * 2] for i in range(len(T))])]
            for name, change in cases:
                if name != "honest" and self.args.only not in name:
                    continue
                yield world, f"{session}, {name}", self.changed(source, lines(stamps, change(poses))), truth

    def fuse(self):
        for world, name, folder, truth in self.recordings():
            kind = name.split(", ")[1]
            path = f"{self.folder}/fused.xvm"
            shutil.copy(self.map_of(world), path)
            if self.run("fuse", folder, path, "-q").returncode != 0:
                self.note("fuse", kind, "refused")
                continue
            rows = sqlite3.connect(path).execute(
                "SELECT number, x, y, z FROM keyframes WHERE source = (SELECT max(id) FROM sources)").fetchall()
            off = [np.linalg.norm(np.array(row[1:]) - truth[row[0]][:3, 3]) for row in rows]
            bad = sum(o > (0.5 if world in ROOMS else 2) for o in off)
            self.note("fuse", kind, "WRONG" if bad else "right",
                      f"{world} {name}: {bad} of {len(off)} key frames off, at most {max(off):.1f} m")

    def windows(self):
        """--sequence, --track and --trajectory."""
        for world, name, folder, truth in self.recordings():
            kind = name.split(", ")[1]
            tolerance = 0.5 if world in ROOMS else 5
            size = "50" if world in ROOMS else "30"
            for flag in ("--sequence", "--track"):
                trajectory = f"{self.folder}/trajectory.txt"
                if os.path.exists(trajectory):
                    os.remove(trajectory)
                out = self.run("localize", folder, self.map_of(world), "--window", size, "--stride", "10", flag,
                               "--trajectory", trajectory, "--json", "-q")
                for line in out.stdout.splitlines():
                    self.judge(world, flag, kind, json.loads(line), truth)
                stamps = read_poses(f"{folder}/poses.txt")[0]
                if not os.path.exists(trajectory) or stamps is None:
                    continue
                off = [np.linalg.norm(T[:3, 3] - truth[int(np.argmin(np.abs(np.array(stamps) - s)))][:3, 3])
                       for s, T in zip(*read_poses(trajectory))]
                bad = sum(o > tolerance for o in off)
                self.note("--trajectory", kind, "WRONG" if bad else "right",
                          f"{world} {name} with {flag}: {bad} of {len(off)} poses off, at most {max(off):.1f} m")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--data", default="../shared/data")
    parser.add_argument("--xview", default="build/xview")
    parser.add_argument("--windows", type=int, default=600)
    parser.add_argument("--per-window", type=int, default=8, help="faults tried on each window")
    parser.add_argument("--only", default="", help="faults whose name has this in it")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--what", default="localize,fuse,windows")
    parser.add_argument("--worlds", nargs="*", metavar="WORLD:SESSIONS:FRAMES[:room]",
                        help="folders of --data with a recording `forward` each, instead of the usual ones")
    args = parser.parse_args()
    if args.worlds:
        WORLDS.clear()
        for world, sessions, frames, *room in (spec.split(":") for spec in args.worlds):
            WORLDS[world] = (sessions.split(","), int(frames))
            ROOMS.update([world] if room else [])
    trials = Trials(args)
    for what in trials.args.what.split(","):
        getattr(trials, what)()
    print("\n| what | fault | right | WRONG | refused | error |\n|---|---|---|---|---|---|")
    total = collections.Counter()
    for (what, kind), count in sorted(trials.counts.items()):
        print(f"| {what} | {kind} | " + " | ".join(str(count[k]) for k in ("right", "WRONG", "refused", "error")) + " |")
        if kind != "honest":
            total.update(count)
    print(f"with a fault: {dict(total)}")
    shutil.rmtree(trials.folder, ignore_errors=True)
    return 1 if trials.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
