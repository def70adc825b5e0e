#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Answers of localize for bare graphs, with their truth: what `xview learn --verdict` learns for queries without points.

Discs of several radii are cut out of graphs of one visit and localized in those of another one, and in places elsewhere. Real
graphs are the extracts of OpenStreetMap and the maps of poles of the data folder; graphs of simulated worlds, of the program's own
simulator and of bench/other_worlds, are made of recordings at their true poses. Discs whose square tiles are exchanged for one
another, so that no pose has more than a part of them in place, have no truth. Every place is a file of answers of its own, so
that it can be left out. Beside each disc stands its true pose, DISC.truth.txt. What is there already is kept.
"""
import argparse
import math
import shutil
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import regress_worlds as worlds
import verdict_table as tables
from regress import simulated

OWN = ("suburb", "grid", "village", "campus")
OTHER = ("oldtown", "motorway", "carpark")
REAL_RADII_M, SIMULATED_RADII_M = (40, 60, 100, 200), (20, 30, 45, 60)
ONLY_GROUND = [f"--sessions.{name}=false" for name in ("aerial", "oblique", "elsewhere")]
LEAST = 8  # vertices of a disc
LEAST_EXCHANGED_M = 60  # smaller discs have a vertex or two in a tile
REAL_DISCS, SIMULATED_DISCS = 30, 10  # of a radius


def run(program, *arguments, codes=(0,)):
    done = subprocess.run([str(program), *map(str, arguments)], stdout=subprocess.PIPE, text=True)
    if done.returncode not in codes:
        sys.exit(f"{program} {' '.join(map(str, arguments))}: ended with {done.returncode}")
    return done.stdout


def at_true_poses(session, target):
    """The recording with its true poses instead of those of odometry."""
    if not target.exists():
        target.mkdir(parents=True)
        for path in session.iterdir():
            if path.name not in ("poses.txt", "poses.tum"):
                (target / path.name).symlink_to(path.resolve())
        shutil.copy(session / "groundtruth.txt", target / "poses.txt")
    return target


def graph_of(program, session, made):
    """The vertices of the graph of a recording, as a file."""
    file, whole = made / f"{session.name}_vertices.ply", made / f"{session.name}.ply"
    if not file.exists():
        if not whole.exists():
            run(program, "graph", "-q", "--threads", 1, at_true_poses(session, made / session.name), whole)
        lines = whole.read_text().splitlines()
        edges, end = (next(i for i, line in enumerate(lines) if line.startswith(word)) for word in ("element edge", "end_header"))
        count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
        file.write_text("\n".join([*lines[:edges], *lines[end:end + 1 + count], ""]))
    return file


def most_within(radius_m, vertices):
    """Of the first vertices, which are enough to tell whether discs can be cut at all."""
    return max((sum(math.dist(v[:2], w[:2]) <= radius_m for w in vertices) for v in vertices[:50]), default=0)


def without_truth(path, folder):
    """The disc under another name, beside which no truth stands."""
    folder.mkdir(parents=True, exist_ok=True)
    classes = path.with_name("classes.yaml")
    if classes.exists():
        shutil.copy(classes, folder / "classes.yaml")
    target = folder / f"{path.parent.name}_{path.name}"
    shutil.copy(path, target)
    return target


def with_tiles_exchanged(path, radius_m, folder):
    """The disc with its square tiles, a third of the radius wide, in random order, as a file beside which no truth stands."""
    target = without_truth(path, folder)
    header, vertices = worlds.read_ply(target)
    side_m = radius_m / 3
    tiles = sorted({(v[0] // side_m, v[1] // side_m) for v in vertices})
    moved = dict(zip(tiles, worlds.random_of("tiles", path.name).sample(tiles, len(tiles))))
    for v in vertices:
        tile = v[0] // side_m, v[1] // side_m
        for axis in (0, 1):
            v[axis] += side_m * (moved[tile][axis] - tile[axis])
    worlds.write_ply(target, header, vertices)
    return target


def cut_discs(file, made, name, radii_m, count, classes=None):
    """Paths by radius; a disc that was cut has its truth beside it."""
    vertices = worlds.read_ply(file)[1]
    for radius_m in radii_m:
        if most_within(radius_m, vertices) < 2 * LEAST:
            continue
        cut = worlds.discs(file, made, f"{name}_{radius_m}", radius_m, LEAST, count, classes)
        for path, T in cut.items():
            path.with_suffix(".truth.txt").write_text(" ".join(f"{x:.9f}" for row in T[:3] for x in row) + "\n")
        yield radius_m, list(cut)


def places(arguments):
    """(name, map, discs of the same place by radius, discs of elsewhere by radius)."""
    data, made = arguments.data, arguments.work / "discs"
    osm, poles = data / "osm", data / "pole_maps"
    later = {"monaco": osm / "monaco_2020-07-19.ply", "andorra": osm / "andorra_2021-10-28.ply"}
    earlier = {"monaco": osm / "monaco_2012-07-06.ply", "andorra": osm / "andorra_2020-05-01.ply"}
    cut = {name: list(cut_discs(file, made, name, REAL_RADII_M, REAL_DISCS, osm / "classes.yaml")) for name, file in later.items()}
    for name, file in earlier.items():
        yield name, file, cut[name], [d for other in later if other != name for d in cut[other]]
    campus = list(cut_discs(poles / "poles_nclt_gt.ply", made, "campus", REAL_RADII_M, REAL_DISCS))
    yield "campus", poles / "poles_nclt_auto.ply", campus, []
    own = [tables.World(style, seed, 0.83 if seed % 2 else 0.68) for style in OWN for seed in arguments.seeds]
    other = [tables.World(style, seed, tables.OTHER_QUALITY) for style in OTHER for seed in arguments.seeds[:1]]
    graphs = {}
    for world in own + other:
        name = tables.name_of(world)
        if world.style in OTHER:
            folder = tables.of_another_make(arguments.program.parent / "bench/other_worlds", arguments.work, world)
        else:
            folder = simulated(arguments.program, arguments.work, name, [*tables.flags_of(world, False), *ONLY_GROUND])
        sessions = [folder / s for s in ("forward", "rear", "forward2") if (folder / s / "groundtruth.txt").exists()]
        graphs[world] = [graph_of(arguments.program, session, arguments.work / "graphs" / name) for session in sessions]
    cut = {world: [d for file in files[1:] for d in cut_discs(file, made, f"{tables.name_of(world)}_{file.stem}",
                                                               SIMULATED_RADII_M, SIMULATED_DISCS)] for world, files in graphs.items()}
    for world in own + other:
        alike = [another for another in (own if world in own else other) if another != world and
                 (world in other or another.style == world.style)]
        elsewhere = [disc for another in alike for disc in cut[another]][:4]
        yield tables.name_of(world), graphs[world][0], cut[world], elsewhere


def main():
    root = Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("answers", type=Path, metavar="DIR", help="one .jsonl per place")
    add("--data", type=Path, default=root.parent / "shared/data", help="folder with osm and pole_maps")
    add("--program", type=Path, default=root / "build/xview", help="default: that of build/")
    add("--work", type=Path, default=root / "build/graph_table", help="where worlds and discs are kept")
    add("--seeds", type=int, nargs="+", default=[202, 203, 204, 205])
    arguments = parser.parse_args()
    arguments.work, arguments.program = arguments.work.resolve(), arguments.program.resolve()
    (arguments.work / "worlds").mkdir(parents=True, exist_ok=True)
    arguments.answers.mkdir(parents=True, exist_ok=True)
    for name, place, here, elsewhere in places(arguments):
        file = arguments.answers / f"{name}.jsonl"
        if file.exists():
            continue
        queries = [path for _, paths in here for path in paths]
        queries += [without_truth(path, arguments.work / "elsewhere" / name) for _, paths in elsewhere for path in paths]
        queries += [with_tiles_exchanged(path, radius_m, arguments.work / "exchanged" / name)
                    for radius_m, paths in here for path in paths if radius_m >= LEAST_EXCHANGED_M]
        if not queries:
            continue
        text = run(arguments.program, "localize", "--json", "-q", "--threads", 1, *queries, place, codes=(0, 3))
        file.write_text(text)
        print(f"{name}: {len(text.splitlines())} answers", file=sys.stderr)


if __name__ == "__main__":
    main()
