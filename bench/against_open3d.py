#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pairs of clouds without labels: xview beside Open3D (FPFH, RANSAC, ICP), on the same files, each in a process of its own.

    bench/against_open3d.py [DATA] [--program build/xview] [--work build/raw_pairs] [--page docs/results/against_open3d.md]

The pairs are those of bench/turned.py, none of them turned. Open3D: voxels of 0.8 m outdoors, 0.1 m in rooms and 0.05 m
before a table, FPFH of 5 voxels, RANSAC of 100,000 steps over mutual matches, ICP to planes; it has no verdict, its
fitness is the share of the query within 0.4 voxels of the map. Times are CPU time of the whole process on one thread,
reading and importing included. Needs the package python3-open3d; prints a Markdown table, and writes the page if asked.
"""
import argparse
import json
import math
import os
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table, wrapped
from raw_pairs import error_m, middle_of
from turned import recorded_pairs

VOXELS_M = {"kitchen": 0.05, "apartment": 0.1, "tls_corridor": 0.1}  # by folder; elsewhere 0.8
INTRO = """# Against Open3D, on the same raw clouds

`bench/against_open3d.py`: the same raw clouds, each program in a process of its own on one thread; CPU time with reading
and importing. Open3D {version}: voxels of 0.8 m, in rooms 0.1 m, before a table 0.05 m; FPFH of 5 voxels, RANSAC of
100,000 steps over mutual matches, ICP to planes; other settings may do better. *Fitness* is its share of the query
within 0.4 voxels of the map; it gives no verdict. xview got no option, and says how likely it is wrong. Right is within
0.5 m at the middle of the query, in rooms 0.2 m.
"""


def by_open3d(query, place, voxel):
    """T_map_query and fitness; in a process of its own."""
    import open3d as o3d
    o3d.utility.random.seed(1)
    o3d.utility.set_verbosity_level(o3d.utility.VerbosityLevel.Error)
    registration, knn = o3d.pipelines.registration, o3d.geometry.KDTreeSearchParamHybrid

    def prepared(path):
        cloud = o3d.io.read_point_cloud(path).remove_non_finite_points().voxel_down_sample(voxel)
        cloud.estimate_normals(knn(2 * voxel, 30))
        return cloud, registration.compute_fpfh_feature(cloud, knn(5 * voxel, 100))

    (source, source_features), (target, target_features) = prepared(query), prepared(place)
    coarse = registration.registration_ransac_based_on_feature_matching(
        source, target, source_features, target_features, True, 1.5 * voxel,
        registration.TransformationEstimationPointToPoint(False), 3,
        [registration.CorrespondenceCheckerBasedOnEdgeLength(0.9),
         registration.CorrespondenceCheckerBasedOnDistance(1.5 * voxel)],
        registration.RANSACConvergenceCriteria(100000, 0.999))
    fine = registration.registration_icp(source, target, 0.4 * voxel, coarse.transformation,
                                         registration.TransformationEstimationPointToPlane())
    print(json.dumps({"T": fine.transformation.ravel().tolist(), "fitness": fine.fitness, "version": o3d.__version__}))


def run(command):
    """Its last line of JSON, with the CPU time of the process [s]."""
    reading, writing = os.pipe()
    pid = os.posix_spawn(command[0], command, {**os.environ, "OMP_NUM_THREADS": "1"},
                         file_actions=[(os.POSIX_SPAWN_DUP2, writing, 1), (os.POSIX_SPAWN_CLOSE, reading)])
    os.close(writing)
    with os.fdopen(reading) as said:
        lines = said.read().splitlines()
    _, status, usage = os.wait4(pid, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 3) or not lines:
        sys.exit(f"failed: {' '.join(command)}")
    return {**json.loads(lines[-1]), "s": usage.ru_utime + usage.ru_stime}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", nargs="?", default=os.environ.get("XVIEW_DATA", "../shared/data"), type=Path)
    parser.add_argument("--program", default="build/xview")
    parser.add_argument("--work", default="build/raw_pairs", type=Path)
    parser.add_argument("--page", type=Path)
    parser.add_argument("--one", nargs=3, metavar=("QUERY", "MAP", "VOXEL"), help="what a process of Open3D is asked")
    given = parser.parse_args()
    if given.one:
        return by_open3d(given.one[0], given.one[1], float(given.one[2]))
    if subprocess.run([sys.executable, "-c", "import open3d"], stderr=subprocess.DEVNULL).returncode != 0:
        sys.exit("open3d is not there: apt-get install python3-open3d")
    rows, sums = [], {"xview": [], "open3d": []}
    for name, query, place, T_true, right_m in recorded_pairs(given.data, given.work / "clouds"):
        voxel = VOXELS_M.get(query.parent.name, 0.8)
        ours = run([given.program, "localize", str(query), str(place), "--json", "-q", "--threads", "1"])
        theirs = run([sys.executable, __file__, "--one", str(query), str(place), str(voxel)])
        off = {"xview": math.inf, "open3d": math.inf}
        if T_true:
            middle = middle_of(query)
            off = {"xview": error_m(ours.get("T_map_query"), T_true, middle),
                   "open3d": error_m(theirs["T"], T_true, middle)}
        right = {who: off[who] <= right_m for who in off}
        yes = ours["status"] == "accepted"
        sums["xview"].append((T_true is not None, right["xview"], ours["s"], yes))
        sums["open3d"].append((T_true is not None, right["open3d"], theirs["s"], theirs["fitness"]))

        def place_of(who):
            return "" if not T_true else f"{off[who]:.3f} m, " if off[who] < 100 else "> 100 m, "

        rows.append([name + ("" if T_true else ": negative"),
                     f"{place_of('xview')}{ours['status']} ({ours['p_wrong']:.1g}), {ours['s']:.2f} s",
                     f"{place_of('open3d')}{theirs['fitness']:.2f}, {theirs['s']:.2f} s"])
    own = sum(is_own for is_own, *_ in sums["xview"])
    accepted = [(is_own, right) for is_own, right, _, yes in sums["xview"] if yes]
    fits = {way: [fitness for is_own, right, _, fitness in sums["open3d"] if (is_own and right) == way]
            for way in (True, False)}
    ratio = statistics.geometric_mean(b[2] / a[2] for a, b in zip(sums["xview"], sums["open3d"]))
    rows += [[f"**right, of {own}**", *(str(sum(right for _, right, *_ in sums[who])) for who in sums)],
             ["**accepted: right, wrong**", f"{sum(a and b for a, b in accepted)}, "
              f"{sum(not (a and b) for a, b in accepted)}",
              f"fitness of right ones from {min(fits[True]):.2f}, of others to {max(fits[False]):.2f}"],
             ["**CPU time over that of xview, geometric mean**", "1", f"{ratio:.1f}"]]
    text = table([["pair", "xview (chance to be wrong)", "Open3D: fitness"], *rows])
    print(text)
    if given.page:
        given.page.write_text(wrapped(INTRO.format(version=theirs["version"])) + "\n" + text + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
