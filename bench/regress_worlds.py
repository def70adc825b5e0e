# SPDX-License-Identifier: BSD-3-Clause
"""The worlds of the regression check: which recordings are the map, which are searched for in it, and the truth."""
import hashlib
import math
import random
import shutil
import struct
from collections import namedtuple
from pathlib import Path

from regress_poses import from_numbers, from_quaternion, inverse, product, turned_about_z

# One run of localize. truth(answer) gives T_map_sensor of its last frame, or is None for strangers.
Part = namedtuple("Part", "map queries flags truth")
Map = namedtuple("Map", "inputs flags")
# One line of the table. An accepted pose further off than wrong_m is a wrong one.
Row = namedtuple("Row", "world session window parts wrong_m")

OUTDOORS_M, INDOORS_M, DESK_M = 5.0, 0.5, 0.15
WINDOWS_PER_ROW = 15


# ---- Files ----


def lines_of(file):
    return [line.split() for line in Path(file).read_text().splitlines() if line.strip() and line[0] != "#"]


def matrices_in(file):
    return [from_numbers(words) for words in lines_of(file)]


def random_of(*name):
    """Always the same numbers for the same name, on any machine."""
    return random.Random(hashlib.sha256("/".join(map(str, name)).encode()).hexdigest())


def random_move(*name):
    """An odometry origin of its own: any heading, some hundred metres off, z still up."""
    chance = random_of("move", *name)
    x, y, z = chance.uniform(-200, 200), chance.uniform(-200, 200), chance.uniform(-3, 3)
    return turned_about_z(chance.uniform(0, 2 * math.pi), x, y, z)


# ---- Recordings ----

def frame_numbers(folder):
    images = next(folder / name for name in ("depth", "velodyne") if (folder / name).is_dir())
    return sorted(int(file.stem) for file in images.iterdir())


def odometry_of(folder):
    """T_odom_sensor by frame number. Poses of SemanticKITTI folders are those of camera 0."""
    poses, numbers = matrices_in(folder / "poses.txt"), frame_numbers(folder)
    if (folder / "calib.txt").exists():
        Tr = from_numbers(next(words[1:] for words in lines_of(folder / "calib.txt") if words[0] == "Tr:"))
        poses = [product(inverse(Tr), T, Tr) for T in poses]
    return dict(zip(numbers, poses))


def part_of(folder, target, keep, move):
    """The frames that keep(position) chooses as a recording of their own, made of links, with its odometry moved.

    Returns its path and the odometry of those frames before the move, which is the truth if that was the map's frame.
    """
    shutil.rmtree(target, ignore_errors=True)
    odometry = odometry_of(folder)
    kept = {number for position, number in enumerate(sorted(odometry)) if keep(position)}
    for source in sorted(folder.rglob("*")):
        place = target / source.relative_to(folder)
        if source.parent != folder and source.is_file() and int(source.stem) in kept:
            place.parent.mkdir(parents=True, exist_ok=True)
            place.symlink_to(source.resolve())
    for name in ("camera.yaml", "classes.yaml"):
        if (folder / name).exists():
            shutil.copy(folder / name, target / name)
    if (folder / "calib.txt").exists():
        (target / "calib.txt").write_text("Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n")
    moved = [sum(product(move, odometry[number])[:3], []) for number in sorted(kept)]
    (target / "poses.txt").write_text("".join(" ".join(f"{v:.9f}" for v in numbers) + "\n" for numbers in moved))
    return target, {number: odometry[number] for number in sorted(kept)}


def truth_of_frames(poses):
    return lambda answer: poses[answer["query"]["last_frame"]]


def truth_of_queries(transforms):
    """Of graphs and clouds, by the true T_map_query of each file. Where the sensor is in the query the answer tells."""
    true_of = {path.name: T for path, T in transforms.items()}

    def truth(answer):
        T_query_map = inverse(from_numbers(answer["T_map_query"]))
        T_map_sensor = from_quaternion(answer["pose"]["position"], answer["pose"]["quaternion"])
        return product(true_of[Path(answer["query"]["input"]).name], T_query_map, T_map_sensor)
    return truth


def true_poses(folder, file="groundtruth.txt"):
    return truth_of_frames(dict(zip(frame_numbers(folder), matrices_in(folder / file))))


def metres_per_frame(folder):
    poses = list(odometry_of(folder).values())
    steps = [math.dist([a[i][3] for i in range(3)], [b[i][3] for i in range(3)]) for a, b in zip(poses, poses[1:])]
    return sum(steps) / len(steps)


def windows(folder, metres):
    """Flags for windows so long, about WINDOWS_PER_ROW of them over the recording; 0 m is one frame."""
    frames, spacing = len(frame_numbers(folder)), metres_per_frame(folder)
    size = max(1, min(frames, round(metres / spacing)))
    return ["--window", str(size), "--stride", str(max(1, round((frames - size) / (WINDOWS_PER_ROW - 1))))]


def drive_rows(world, folder, place, lengths_m, truth, wrong_m):
    for metres in lengths_m:
        part = Part(place, [folder], windows(folder, metres), truth)
        yield Row(world, folder.name, f"{metres} m" if metres else "1 frame", [part], wrong_m)


# ---- Graphs and clouds in PLY ----

NUMBERS = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}


def read_ply(file):
    """Header lines and vertices as lists of numbers, x y z first."""
    header, _, body = Path(file).read_bytes().partition(b"end_header\n")
    header = header.decode().splitlines()
    count = int(next(line.split()[2] for line in header if line.startswith("element vertex")))
    kinds = [NUMBERS[line.split()[1]] for line in header if line.startswith("property")]
    if any(line.startswith("format binary") for line in header):
        return header, [list(v) for v in struct.iter_unpack("<" + "".join(kinds), body)][:count]
    number = [float if kind in "fd" else int for kind in kinds]
    return header, [[to(word) for to, word in zip(number, line.split())] for line in body.decode().splitlines()[:count]]


def moved_ply(file, target, middle, radius_m, heading, classes=None):
    """What stands within radius_m of middle, seen from there and turned; returns the path and the true T_map_query.

    Instances are numbered anew, because those of the source name the same thing in the map.
    """
    header, vertices = read_ply(file)
    T_map_query = turned_about_z(heading, *middle)
    T, inside, renamed = inverse(T_map_query), [], {}
    named = [line.split()[-1] for line in header if line.startswith("property")].index("instance")
    for v in vertices:
        if math.dist(v[:2], middle[:2]) <= radius_m:
            v[named] = renamed.setdefault(v[named], len(renamed) + 1)
            inside.append([sum(T[i][k] * v[k] for k in range(3)) + T[i][3] for i in range(3)] + v[3:])
    write_ply(target, header, inside)
    if classes:
        shutil.copy(classes, target.parent / "classes.yaml")
    return target, T_map_query


def write_ply(target, header, vertices):
    """As ASCII; header and vertices as read_ply() has them."""
    header = [re_counted(line, len(vertices)) for line in header]
    target.parent.mkdir(parents=True, exist_ok=True)
    lines = [" ".join([f"{x:.4f}" for x in v[:3]] + [str(x) for x in v[3:]]) for v in vertices]
    target.write_text("\n".join([*header, "end_header", *lines, ""]))


def re_counted(line, count):
    if line.startswith("element vertex"):
        return f"element vertex {count}"
    return "format ascii 1.0" if line.startswith("format") else line


def middle_of(vertices):
    return [sum(v[i] for v in vertices) / len(vertices) for i in range(3)]


def discs(file, made, name, radius_m, least, count, classes=None):
    """Discs around random vertices with at least so many vertices in each, by path with their true T_map_query."""
    vertices = read_ply(file)[1]
    chance, cut = random_of("discs", name), {}
    while len(cut) < count:
        x, y = (c + chance.uniform(-10, 10) for c in chance.choice(vertices)[:2])
        if sum(math.dist(v[:2], (x, y)) <= radius_m for v in vertices) >= least:
            target = made / name / f"disc_{len(cut):02}.ply"
            cut.update([moved_ply(file, target, [x, y, 0.0], radius_m, chance.uniform(0, 2 * math.pi), classes)])
    return cut


def graphs_row(world, session, window, place, transforms, flags, wrong_m, stranger=False):
    truth = None if stranger else truth_of_queries(transforms)
    return Row(world, session, window, [Part(place, list(transforms), flags, truth)], wrong_m)


# ---- Worlds ----


def town(drives, lengths_m, wrong_m, first="forward", stranger="elsewhere"):
    """A world of recordings with groundtruth.txt in the frame of the first."""

    def rows(world, folder, made):
        place = Map([folder / first], [])
        for name in drives:
            yield from drive_rows(world, folder / name, place, lengths_m, true_poses(folder / name), wrong_m)
        yield from drive_rows(world, folder / stranger, place, lengths_m, None, wrong_m)

    return rows


def kitti00(world, folder, made):
    street = Map([folder / "map"], [])
    for session, truth in (("query_4501", true_poses(folder / "query_4501", "truth.txt")), ("negative_850", None)):
        part = Part(street, [folder / session], ["--window", "1"], truth)
        yield Row(world, session, "1 frame", [part], OUTDOORS_M)
    yield left_out(world, folder / "map", made, 3)


def left_out(world, folder, made, every):
    """One frame of so many is searched for, alone, in the map of the others."""
    identity = turned_about_z(0)
    rest, _ = part_of(folder, made / "rest", lambda i: i % every != 1, identity)
    query, truth = part_of(folder, made / "left_out", lambda i: i % every == 1, random_move(world))
    part = Part(Map([rest], []), [query], ["--window", "1"], truth_of_frames(truth))
    return Row(world, f"1 of {every} left out", "1 frame", [part], OUTDOORS_M)


def nuscenes32(world, folder, made):
    yield left_out(world, folder, made, 2)
    yield left_out(world, folder, made / "3", 3)


def pandaset(world, folder, made):
    scans = Map([folder / "pandar64"], [])
    front = Map([folder / name for name in ("front_camera", "front_left_camera", "front_right_camera")], [])
    aside, ahead = ("left_camera", "right_camera", "back_camera"), [path.name for path in front.inputs]
    sessions = [(scans, name, "in scans") for name in (*ahead, *aside, "pandargt")]
    sessions += [(front, name, "in front") for name in aside]
    for place, name, where in sessions:
        own_frame = folder / name / "truth.txt"
        # The matrix of truth.txt stands in one line of 16 numbers.
        T_map_odom = from_numbers(sum(lines_of(own_frame), [])) if own_frame.exists() else turned_about_z(0)
        query, odometry = part_of(folder / name, made / name, lambda i: True, random_move(name))
        truth = truth_of_frames({number: product(T_map_odom, T) for number, T in odometry.items()})
        for size, stride in ((len(odometry), 1), (6, 2)):
            if size <= len(odometry):
                part = Part(place, [query], ["--window", str(size), "--stride", str(stride)], truth)
                yield Row(world, f"{name} {where}", f"{size} frames", [part], OUTDOORS_M)


def osm(world, folder, made):
    """Discs of the later extract in the earlier one, and in that of the other country."""
    later = {"monaco": folder / "monaco_2020-07-19.ply", "andorra": folder / "andorra_2021-10-28.ply"}
    earlier = {"monaco": folder / "monaco_2012-07-06.ply", "andorra": folder / "andorra_2020-05-01.ply"}
    for radius_m, least in ((60, 12), (200, 30)):
        for query in later:
            cut = discs(later[query], made, f"{query}_{radius_m}", radius_m, least, 20, folder / "classes.yaml")
            for country in earlier:
                place, window = Map([earlier[country]], []), f"{radius_m} m discs"
                yield graphs_row(world, f"{query} in {country}", window, place, cut, [], OUTDOORS_M, query != country)


def pole_maps(world, folder, made):
    for query, place in (("gt", "auto"), ("auto", "gt")):
        file, campus = folder / f"poles_nclt_{query}.ply", Map([folder / f"poles_nclt_{place}.ply"], [])
        heading = random_of(file.name).uniform(0, 2 * math.pi)
        whole = moved_ply(file, made / f"whole_{query}.ply", middle_of(read_ply(file)[1]), math.inf, heading)
        cut = discs(file, made, f"discs_{query}", 100, 20, 15)
        for window, queries in (("whole", dict([whole])), ("100 m discs", cut)):
            yield graphs_row(world, f"{query} in {place}", window, campus, queries, [], OUTDOORS_M)


def tum_fr2_desk(world, folder, made):
    graphs = folder / "graphs"
    truth = {words[0]: from_numbers(words[3:]) for words in lines_of(graphs / "truth.txt")}

    def row(session, pairs):
        parts = []
        for query, place in pairs:
            path, desk = graphs / f"{query}_query.ply", Map([graphs / f"{place}_map.ply"], [])
            parts.append(Part(desk, [path], [], truth_of_queries({path: truth[query]})))
        return Row(world, session, "whole", parts, DESK_M)

    quarters = [f"quarter_{i}" for i in range(4)]
    yield row("halves", [("half_0", "half_1"), ("half_1", "half_0")])
    yield row("quarters in halves", [(q, "half_1" if i < 2 else "half_0") for i, q in enumerate(quarters)])
    yield row("quarters", [(q, p) for q in quarters for p in quarters if p != q])


def rooms(world, folder, made):
    names = ["--labels", str(folder / "scannet0000_classes.yaml")]
    scannet = Map([folder / "scannet0000_map_human_boxes.ply"], names)
    raw = folder / "scannet0000_query_network_objects.ply"
    file, T_raw_query = moved_ply(raw, made / raw.name, middle_of(read_ply(raw)[1]), math.inf, 1.0)
    T_map_raw = from_numbers(lines_of(folder / "scannet0000_truth.txt")[0])
    yield graphs_row(world, "scannet", "whole", scannet, {file: product(T_map_raw, T_raw_query)}, names, INDOORS_M)
    for query, place in ((1, 2), (2, 1)):
        scan, other = (folder / f"3rscan_subscan_{i}.ply" for i in (query, place))
        moved = dict([moved_ply(scan, made / scan.name, middle_of(read_ply(scan)[1]), math.inf, query)])
        room = Map([other], [])
        yield graphs_row(world, f"3rscan {query} in {place}", "whole", room, moved, [], INDOORS_M)
        yield graphs_row(world, f"3rscan {query} in scannet", "whole", scannet, moved, [], INDOORS_M, stranger=True)
    names, house = ["--labels", str(folder / "mp3d_classes.yaml")], {folder / "mp3d_house.ply": None}
    yield graphs_row(world, "mp3d in scannet", "whole", scannet, house, names, INDOORS_M, stranger=True)


def mosd(world, folder, made):
    """Scenes of a table seen by a Kinect: each in itself, and in the others, where it is a stranger."""
    scenes = sorted(folder.glob("*.pcd"))
    itself = [Part(Map([scene], []), [scene], [], truth_of_queries({scene: turned_about_z(0)})) for scene in scenes]
    yield Row(world, "in itself", "whole", itself, DESK_M)
    others = [Part(Map([place], []), [scene for scene in scenes if scene != place], [], None) for place in scenes]
    yield Row(world, "in another", "whole", others, DESK_M)


def laser_teach_repeat(world, folder, made):
    parts = []
    for scan, place, *numbers in lines_of(folder / "truth.txt"):
        path = folder / f"{scan}.pcd"
        truth = truth_of_queries({path: from_numbers(numbers)})
        parts.append(Part(Map([folder / f"{place}.pcd"], []), [path], [], truth))
    yield Row(world, "scans", "1 frame", parts, OUTDOORS_M)


def whole_in_map(wrong_m, windows=()):
    """Folders `map` and `query` with query/truth.txt: all of the query, and windows of some frames."""

    def rows(world, folder, made):
        place, query = Map([folder / "map"], []), folder / "query"
        T_map_odom = from_numbers(sum(lines_of(query / "truth.txt"), []))
        truth = truth_of_frames({number: product(T_map_odom, T) for number, T in odometry_of(query).items()})
        for size in (len(frame_numbers(query)), *windows):
            part = Part(place, [query], ["--window", str(size), "--stride", str(max(1, size // 2))], truth)
            yield Row(world, "query", f"{size} frames", [part], wrong_m)

    return rows


def cloud_in_cloud(query, place, truth, wrong_m):
    """One cloud in another, with a file of T_map_query."""

    def rows(world, folder, made):
        transforms = {folder / query: from_numbers(sum(lines_of(folder / truth), []))}
        part = Part(Map([folder / place], []), [folder / query], [], truth_of_queries(transforms))
        yield Row(world, Path(query).stem, "whole", [part], wrong_m)

    return rows


def rellis3d(world, folder, made):
    """A scan of one sensor in a scan of another: without labels in one without, and in a labelled one."""
    scan, T = folder / "query" / "000000.pcd", from_numbers(sum(lines_of(folder / "query/truth.txt"), []))
    truth = truth_of_queries({scan: T})
    raw = unlabelled(folder / "map", made / "raw_map")
    for session, place in (("raw in raw", raw), ("raw in labelled", folder / "map")):
        yield Row(world, session, "1 frame", [Part(Map([place], []), [scan], [], truth)], OUTDOORS_M)


def submaps(world, folder, made):
    """Some scans as one cloud without labels, in the cloud of the others."""
    for first, last in ((0, 7), (7, 14), (14, 21)):
        inside = range(first, last)
        place = Map([fused(part_of(folder / "map", made / f"rest_{first}", lambda i: i not in inside,
                                   turned_about_z(0))[0], made / f"rest_{first}.pcd")], [])
        move = random_move(world, first)
        some = part_of(folder / "map", made / f"some_{first}", lambda i: i in inside, move)[0]
        query = fused(some, made / f"some_{first}.pcd")
        truth = truth_of_queries({query: inverse(move)})
        yield Row(world, f"scans {first} to {last}", "whole", [Part(place, [query], [], truth)], OUTDOORS_M)


# Recordings of places that have nothing in common, by name: what is a map of each; what is searched for, with flags.
REAL_PLACES = {
    "kitti00": ["kitti00/map"], "nuscenes32": ["nuscenes32"], "pandaset": ["pandaset/pandar64"],
    "laser_teach_repeat": ["laser_teach_repeat/map_0.pcd"], "registration": ["registration/target.ply"],
    "als_megaplot": ["als_megaplot/map.pcd"], "ship_corner": ["ship_corner/map_cad.pcd"],
    "rgbd_7scenes": ["rgbd_7scenes/map"], "rgbd_sun3d": ["rgbd_sun3d/map"],
}
REAL_QUERIES = {
    "kitti00": (["kitti00/map"], ["--window", "1", "--stride", "3"]),
    "nuscenes32": (["nuscenes32"], ["--window", "1", "--stride", "3"]),
    "pandaset": (["pandaset/pandar64"], ["--window", "3"]),
    "laser_teach_repeat": ([f"laser_teach_repeat/scan_{i}.pcd" for i in range(9)], []),
    "registration": (["registration/source.ply"], []), "rellis3d": (["rellis3d/query/000000.pcd"], []),
    "als_megaplot": (["als_megaplot/query_0.pcd"], []), "ship_corner": (["ship_corner/query_slam.pcd"], []),
    "rgbd_7scenes": (["rgbd_7scenes/query"], ["--window", "5", "--stride", "3"]),
    "rgbd_sun3d": (["rgbd_sun3d/query"], ["--window", "5", "--stride", "3"]),
}


def real_strangers(world, folder, made):
    """Every real recording in the maps of the others: one row per recording."""
    for query, (files, flags) in REAL_QUERIES.items():
        inputs = [folder / file for file in files]
        parts = [Part(Map([folder / file for file in of], []), inputs, flags, None)
                 for place, of in REAL_PLACES.items() if place != query]
        yield Row(world, query, "some", parts, OUTDOORS_M)


# ---- The same without labels ----


def unlabelled(folder, target):
    """A recording without its labels, made of links."""
    shutil.rmtree(target, ignore_errors=True)
    for source in folder.rglob("*"):
        place = target / source.relative_to(folder)
        if source.is_file() and place.relative_to(target).parts[0] not in ("label", "labels", "instance", "classes.yaml"):
            place.parent.mkdir(parents=True, exist_ok=True)
            place.symlink_to(source.resolve())
    return target


def fused(folder, target, voxel_m=0.1):
    """All scans of a SemanticKITTI folder as one PCD in the frame of its odometry, without labels or view-points."""
    points, odometry = {}, odometry_of(folder)
    for number in sorted(odometry):
        (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = odometry[number]
        scan = next((folder / "velodyne").glob(f"*{number:06}.bin")).read_bytes()
        for px, py, pz, _ in struct.iter_unpack("<4f", scan):
            p = (a * px + b * py + c * pz + x, d * px + e * py + f * pz + y, g * px + h * py + i * pz + z)
            points.setdefault((p[0] // voxel_m, p[1] // voxel_m, p[2] // voxel_m), p)
    header = ("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\n"
              "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n").format(len(points))
    target.write_bytes(header.encode() + b"".join(struct.pack("<3f", *p) for p in points.values()))
    return target


def raw_kitti00(world, folder, made):
    raw = {name: unlabelled(folder / name, made / name) for name in ("map", "query_4501", "negative_850")}
    scans, labelled = Map([raw["map"]], []), Map([folder / "map"], [])
    cloud = Map([fused(folder / "map", made / "fused.pcd")], [])
    truth = true_poses(folder / "query_4501", "truth.txt")

    def row(session, place, query, its_truth):
        return Row(world, session, "1 frame", [Part(place, [query], ["--window", "1"], its_truth)], OUTDOORS_M)

    yield row("query_4501", scans, raw["query_4501"], truth)
    yield row("negative_850", scans, raw["negative_850"], None)
    yield row("query_4501 in fused", cloud, raw["query_4501"], truth)
    yield row("negative_850 in fused", cloud, raw["negative_850"], None)
    yield row("query_4501 in labelled", labelled, raw["query_4501"], truth)
    yield row("negative_850 in labelled", labelled, raw["negative_850"], None)
    yield row("labelled query_4501", scans, folder / "query_4501", truth)
    yield row("labelled negative_850", scans, folder / "negative_850", None)


def raw_nuscenes32(world, folder, made):
    """The five sweeps that the study of raw clouds left out."""
    gone, raw = (4, 8, 16, 24, 28), unlabelled(folder, made / "raw")
    rest, _ = part_of(raw, made / "rest", lambda i: i not in gone, turned_about_z(0))
    query, truth = part_of(raw, made / "left_out", lambda i: i in gone, random_move(world))
    part = Part(Map([rest], []), [query], ["--window", "1"], truth_of_frames(truth))
    yield Row(world, "5 left out", "1 frame", [part], OUTDOORS_M)


def raw_pandaset(world, folder, made):
    raw = {name: unlabelled(folder / name, made / name) for name in ("pandar64", "pandargt")}
    T_map_odom = from_numbers(sum(lines_of(folder / "pandargt" / "truth.txt"), []))
    truth = {number: product(T_map_odom, T) for number, T in odometry_of(raw["pandargt"]).items()}
    part = Part(Map([raw["pandar64"]], []), [raw["pandargt"]], ["--window", "3"], truth_of_frames(truth))
    yield Row(world, "pandargt in scans", "3 frames", [part], OUTDOORS_M)


def registration(world, folder, made):
    T = [v for words in lines_of(folder / "T_target_source.txt") for v in words]
    truth = truth_of_queries({folder / "source.ply": from_numbers(T)})
    part = Part(Map([folder / "target.ply"], []), [folder / "source.ply"], [], truth)
    yield Row(world, "source in target", "whole", [part], OUTDOORS_M)


def raw_town(world, folder, made):
    drives = [path.name for path in sorted(folder.iterdir()) if path.is_dir()]
    raw = {name: unlabelled(folder / name, made / name) for name in drives}
    place = Map([raw["forward"]], [])
    for name in ("rear", "oblique", "aerial", "elsewhere"):
        truth = true_poses(raw[name]) if name != "elsewhere" else None
        yield from drive_rows(world, raw[name], place, (60,), truth, OUTDOORS_M)


def own_scans(world, folder, made):
    """Scans of one moment and of 8 m, and single raw ones in the cloud of a whole drive, as many people have them."""
    yield from town(("lidar_reverse",), (8, 0), OUTDOORS_M, "lidar", "lidar_elsewhere")(world, folder, made)
    raw = {name: unlabelled(folder / name, made / name) for name in ("lidar_reverse", "lidar_elsewhere")}
    cloud = Map([fused(folder / "lidar", made / "fused.pcd")], [])
    for name, query in raw.items():
        truth = true_poses(folder / name) if name == "lidar_reverse" else None
        yield Row(world, f"{name} raw in fused", "1 frame", [Part(cloud, [query], windows(query, 0), truth)], OUTDOORS_M)


STREETS_M, ROOMS_M = (60, 30, 15), (10, 5)

# By the name of the folder in DATA_DIR.
WORLDS = {
    "suburb_clean": town(("forward2", "rear", "oblique", "aerial"), STREETS_M, OUTDOORS_M),
    "suburb_noisy": town(("forward2", "rear", "oblique", "aerial"), STREETS_M, OUTDOORS_M),
    "grid_noisy": town(("rear", "aerial"), STREETS_M, OUTDOORS_M),
    "village_poor": town(("rear", "oblique"), STREETS_M, OUTDOORS_M),
    "office_noisy": town(("rear", "other"), ROOMS_M, INDOORS_M),
    "kitti00": kitti00, "nuscenes32": nuscenes32, "pandaset": pandaset, "laser_teach_repeat": laser_teach_repeat,
    "registration": registration, "osm": osm, "pole_maps": pole_maps, "tum_fr2_desk": tum_fr2_desk, "rooms": rooms,
    "mosd": mosd,
    "grid_aside": town(("rear", "oblique"), STREETS_M, OUTDOORS_M),
    "rgbd_7scenes": whole_in_map(DESK_M, (6,)), "rgbd_sun3d": whole_in_map(INDOORS_M),
    "als_megaplot": cloud_in_cloud("query_0.pcd", "map.pcd", "query_0_truth.txt", OUTDOORS_M),
    "ship_corner": cloud_in_cloud("query_slam.pcd", "map_cad.pcd", "query_truth.txt", INDOORS_M),
    "rellis3d": rellis3d,
}

# Recordings with their labels withheld, and in the maps of others: the folder in DATA_DIR, then the rows.
WITHOUT_LABELS = {
    "raw_kitti00": ("kitti00", raw_kitti00), "raw_nuscenes32": ("nuscenes32", raw_nuscenes32),
    "raw_pandaset": ("pandaset", raw_pandaset), "raw_suburb_clean": ("suburb_clean", raw_town),
    "raw_suburb_noisy": ("suburb_noisy", raw_town), "raw_submaps": ("kitti00", submaps),
    "real_strangers": (".", real_strangers),
}

STRANGER = ["--sessions.elsewhere"]
OWN_TOWN = town(("rear", "oblique", "aerial"), (60, 15), OUTDOORS_M)
NO_CAMERAS = ["--sessions.rear=false", "--sessions.aerial=false"]

# Made by `xview simulate`: its flags, then the rows.
SIMULATED = {
    "own_clean": (["--seed", "2001", "--sessions.oblique", *STRANGER], OWN_TOWN),
    "own_noisy": (["--seed", "2002", "--quality", "noisy", "--sessions.oblique", *STRANGER], OWN_TOWN),
    "own_scans": (["--seed", "2003", "--quality", "noisy", "--sessions.lidar", *NO_CAMERAS, *STRANGER], own_scans),
}
