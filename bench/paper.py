#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The experiments of the X-View paper in rendered worlds: as published (config/paper), and with today's default.

Worlds after SYNTHIA, AirSim and StreetView are simulated in four towns, mapped from the forward drive, and windows of
another view are localized in the map. Writes the page and its charts. Worlds and runs are kept in --work by what they depend on,
so that what was broken off goes on where it stopped.
"""
import argparse
import fcntl
import math
import statistics
import sys
import threading
from collections import defaultdict, namedtuple
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
import regress_worlds as worlds
from paper_page import BLUE, GREY, ORANGE, SHADES, Curve, chart, percent, table, wrapped
from regress import Runner, simulated, write_whole

# How a world is made beside its town, its preset and class set, the session to find, the distance that is right, frames
# per window and from one window to the next.
World = namedtuple("World", "flags preset classes session right_m window stride")
# One answer: its town and first frame, error of the best hypothesis, consensus value [m], share of the query's vertices
# outside of the consensus.
Answer = namedtuple("Answer", "window error_m error_x_m s_m outside vertices accepted timing_ms")

# Nothing was chosen on these: the settings of config/paper come from other towns.
TOWNS = {"suburb_41": ["--seed", "41"], "village_42": ["--seed", "42", "--sim.style", "village"],
         "grid_43": ["--seed", "43", "--sim.style", "grid"], "suburb_44": ["--seed", "44"]}
STREET = ["--route_length_m", "970", "--width", "480", "--height", "285", "--view_deg", "100", "--sessions.aerial=false",
          "--sessions.rear=false", "--sessions.rear_now"]
NETWORK = ["--quality", "labels", "--label_noise.accuracy"]
WORLDS = {
    "synthia": World([*STREET, "--sessions.forward2", "--sessions.winter"], "synthia", 8, "rear_now", 20, 15, 9),
    "adapnet": World([*STREET, *NETWORK, "0.973"], "synthia", 8, "rear_now", 20, 15, 9),
    "harder": World([*STREET, "--quality", "noisy", "--label_noise.accuracy", "0.83"], "synthia", 8, "rear_now", 20, 15, 9),
    "airsim": World(["--route_length_m", "500", "--width", "512", "--height", "288", "--aerial.tilt_deg", "0",
                     "--aerial.altitude_m", "50", "--sessions.rear=false", "--sim.hedges"], "airsim", 6, "aerial", 30, 15, 4),
    "streetview": World(["--route_length_m", "750", "--frame_spacing_m", "10", "--width", "480", "--height", "360",
                         "--quality", "noisy", "--label_noise.accuracy", "0.68", "--sessions.aerial=false"],
                        "streetview", 5, "rear", 20, 6, 1),
}
QUICK = World(["--route_length_m", "80", "--width", "160", "--height", "96", "--view_deg", "100", "--sessions.rear=false",
               "--sessions.rear_now", "--sessions.forward2", "--sessions.winter", "--sessions.aerial=false"], "synthia", 8,
              "rear_now", 20, 15, 15)
NAMES = {"synthia": "SYNTHIA, perfect labels", "adapnet": "SYNTHIA, labels of a network (mIoU 0.86)",
         "harder": "harder: mIoU 0.52, stereo depth, drift", "airsim": "AirSim, from the air",
         "streetview": "StreetView, labels of a network"}
PAPER = {"synthia": 0.85, "adapnet": 0.70, "airsim": 0.85, "streetview": 0.65}
EXACT = ("--walks.num_walks", "0")


class NotRun(Exception):
    """Only what has been run before was asked for."""


class Stored(Runner):
    """Gives runs that have been made, and makes none."""

    def run(self, key, arguments):
        if not (self.runs / f"{key}.json").exists():
            raise NotRun
        return super().run(key, arguments)


class Lab:
    """Runs the program in the worlds."""

    def __init__(self, arguments):
        self.arguments, self.missing = arguments, []
        self.runner = (Stored if arguments.stored else Runner)(arguments.program, arguments.work)
        self.worlds = {"synthia": QUICK} if arguments.quick else WORLDS
        self.towns = dict(list(TOWNS.items())[:1] if arguments.quick else TOWNS)
        self.busy = defaultdict(threading.Lock)  # Experiments share maps and runs; none is made twice at a time.

    def folder(self, name, town):
        flags = [*self.worlds[name].flags, *self.towns[town]]
        if self.arguments.stored and not any((self.arguments.work / "worlds").glob(f"{name}_{town}_" + 16 * "[0-9a-f]")):
            raise NotRun
        with self.busy[name, town]:
            return simulated(self.arguments.program, self.arguments.work, f"{name}_{town}", [*flags, "--threads", "1"])

    def flags(self, name, how, classes, more):
        """Of localize; those of the map are the same without what only matching needs."""
        world = self.worlds[name]
        if how == "walks":
            return ["--config", f"paper/{world.preset}", "--labels", f"paper_{classes or world.classes}", *more]
        return [*(["--labels", f"paper_{classes}"] if classes else []), *more]

    def answers(self, name, how="walks", session=None, window=None, classes=None, graph=(), graph_of_map=None, match=()):
        """Of all towns. `graph`: flags of map and query; `graph_of_map`: others for the map; `match`: flags of localize only."""
        found = []
        for town in self.towns:
            world, folder = self.worlds[name], self.folder(name, town)
            query = folder / (session or world.session)
            of_map = graph if graph_of_map is None else graph_of_map
            place = worlds.Map([folder / "forward"], self.flags(name, how, classes, of_map))
            frames = ["--window", str(window or world.window), "--stride", str(world.stride)]
            part = worlds.Part(place, [query], [*frames, *self.flags(name, how, classes, graph)], worlds.true_poses(query))
            with self.busy[self.runner.map_key(place, [])]:
                self.runner.map(place, [])
            with self.busy[str((name, how, part.queries, part.flags, place.flags, match))]:
                run, mapped = self.runner.localize(part, list(match), [])
            if run is None or run["code"] not in (0, 3):
                raise RuntimeError(f"{name}: {(run or mapped)['said']}")
            found += [answer_of(town, a, part.truth) for a in run["answers"]]
        return found

    def each(self, variants, answers_of):
        """Of every variant (its name first) with its answers; those that were not run are noted and left out."""
        for variant in variants:
            try:
                yield variant, answers_of(variant)
            except NotRun:
                self.missing.append(variant[0])


def answer_of(town, answer, truth):
    error = error_x = math.inf
    if answer["hypotheses"]:
        T, position = truth(answer), answer["pose"]["position"]
        error, error_x = math.dist([T[i][3] for i in range(3)], position), abs(T[0][3] - position[0])
    vertices = answer["vertices"]
    outside = 1 - answer["inliers"] / vertices if vertices else 1
    window = town, answer["query"]["first_frame"]
    return Answer(window, error, error_x, answer.get("consensus_m", math.inf), outside, vertices,
                  answer["status"] == "accepted", answer["timing_ms"])


def sureness(answer):
    """By the consensus value in metres; queries without one by the share of vertices that do not agree."""
    return answer.s_m, answer.outside


def success(answers, metres):
    return sum(a.error_m <= metres for a in answers) / len(answers) if answers else math.nan


def surest(answers, parts):
    """The fifth or half with the best consensus; the published scripts count the success of the fifth."""
    return sorted(answers, key=sureness)[:max(1, round(len(answers) / parts))]


def wilson(share, count):
    """95 % interval of a share (Wilson 1927)."""
    z2 = 1.96 ** 2
    middle, half = share + z2 / (2 * count), math.sqrt(z2 * (share * (1 - share) + z2 / (4 * count)) / count)
    return [max(0, (middle - half) / (1 + z2 / count)), min(1, (middle + half) / (1 + z2 / count))]


def with_interval(answers, metres):
    share = success(answers, metres)
    low, high = wilson(share, len(answers))
    return f"{percent(share)} [{100 * low:.0f}-{100 * high:.0f}]"


def precision_recall(answers, metres):
    """One point per t_c: accepted are answers with s <= t_c; recall counts all queries."""
    points, right = [], 0
    ranked = sorted(answers, key=sureness)
    for count, answer in enumerate(ranked, 1):
        right += answer.error_m <= metres
        if count == len(ranked) or sureness(ranked[count]) > sureness(answer):
            points.append((100 * right / len(ranked), 100 * right / count))
    return points


def area(points):
    """Under the curve, by steps; in [0, 1]."""
    before, total = 0, 0
    for recall, precision in points:
        total += (recall - before) * precision
        before = recall
    return total / 1e4


# ---- Experiments: each gives a heading, charts by name, and Markdown ----


def trend(claim, better, worse):
    """`better`, `worse`: answers to the same windows with what the paper says is better and worse, each with the distance
    that is right; compared in pairs by the exact test of McNemar."""
    (a, right_a), (b, right_b) = better, worse
    others = {y.window: y.error_m <= right_b for y in b}
    pairs = [(x.error_m <= right_a, others[x.window]) for x in a if x.window in others]
    only_a, only_b = sum(x and not y for x, y in pairs), sum(y and not x for x, y in pairs)
    count = only_a + only_b
    chance = min(1, 2 * sum(math.comb(count, k) for k in range(min(only_a, only_b) + 1)) / 2 ** count)
    seen = ("No difference can be told here" if chance > 0.05 else "This appears here" if only_a > only_b else
            "Here it is the other way round")
    return (f"**In the paper** {claim}. {seen}: {only_a} windows are right only with the former, {only_b} only with the latter, "
            f"of {len(pairs)} (p = {chance:.2g}).\n\n")


def localization(lab):
    rows = [["world", "right within", "windows", "the paper", "walks, all", "surest half", "surest fifth", "all, along x only",
             "exact walks, all", "of 60 m, all", "of 60 m, exact", "default, all", "default accepted", "of these wrong"]]
    curves, said = [], ""

    def found(variant):
        name, world = variant
        return [lab.answers(name), lab.answers(name, match=EXACT), lab.answers(name, window=2 * world.window),
                lab.answers(name, window=2 * world.window, match=EXACT), lab.answers(name, "default")]

    for (name, world), (walks, exact, longer, longer_exact, default) in lab.each(lab.worlds.items(), found):
        accepted, right_m = [a for a in default if a.accepted], world.right_m
        fifth = success(surest(walks, 5), right_m)
        rows.append([NAMES[name], f"{right_m} m", len(walks), percent(PAPER[name]) if name in PAPER else "–",
                     with_interval(walks, right_m), percent(success(surest(walks, 2), right_m)), percent(fifth),
                     percent(sum(a.error_x_m <= right_m for a in walks) / len(walks)), with_interval(exact, right_m),
                     *(percent(success(answers, right_m)) for answers in (longer, longer_exact, default)),
                     percent(len(accepted) / len(default)), sum(a.error_m > 5 for a in accepted)])
        if name in PAPER:
            said += (f"* {NAMES[name]}: of the surest fifth {percent(fifth)} are within {right_m} m, of all windows "
                     f"{percent(success(walks, right_m))}; the paper has {percent(PAPER[name])}. Today's default: {percent(success(default, right_m))} of all.\n")
        if name in ("synthia", "adapnet"):
            noisy = name != "synthia"
            for how, answers, color in (("walks", walks, ORANGE), ("default", default, BLUE)):
                points = [(d, 100 * success(answers, d)) for d in DISTANCES_M]
                curves.append(Curve(f"{how}, {'network' if noisy else 'perfect'}", points, color, noisy))
    curves.append(Curve("paper at 20 m: 85, 70 %", [(20, 0), (20, 85)], GREY, True))
    return "Success", {"success": chart("Success over distance, SYNTHIA-like", "error of the pose [m]", "queries [%]", curves,
                                        [0.1, 0.3, 1, 3, 10, 30, 100], log=True)}, said + "\n" + table(rows)


def precision(lab):
    """Of the consensus, over t_c, for the number and the length of walks."""
    name, charts, rows = "synthia", {}, [["n", "m", "walks within 20 m", "surest fifth", "area under the curve"]]
    limit, by_setting = lab.worlds[name].right_m, {}
    for chart_name, title, variants in (
            ("walks_n", "n walks of m = 4", [(n, 4) for n in (10, 50, 200, 1000, 0)]),
            ("walks_m", "n = 200 walks of m", [(200, m) for m in (2, 3, 4, 5, 7)])):
        curves = []
        shades = dict(zip(variants, SHADES[1:]))
        named = [(f"{n} walks of {m}", n, m) for n, m in variants]
        for (_, n, m), answers in lab.each(named, lambda v: lab.answers(name, match=matching(*v[1:]))):
            points = precision_recall(answers, limit)
            curves.append(Curve(f"n = {n or 'all'}" if chart_name == "walks_n" else f"m = {m}", points, shades[n, m]))
            rows.append([n or "all", m, with_interval(answers, limit), percent(success(surest(answers, 5), limit)), f"{area(points):.2f}"])
            by_setting[n, m] = answers, limit
        charts[chart_name] = chart(f"Precision and recall over t_c, {title}", "recall [%]", "precision [%]", curves,
                                   x_range=(0, 100))
    said = trend("more walks help, up to about 200 per vertex (200 against 10)", by_setting[200, 4], by_setting[10, 4])
    said += trend("walks of 3 to 5 vertices are best (4 against 7)", by_setting[200, 4], by_setting[200, 7])
    return "Number and length of walks", charts, said + by_default(lab)[1] + table(rows)


def matching(n, m):
    return () if (n, m) == (200, 4) else ("--walks.num_walks", str(n), "--walks.walk_length", str(m))


def compared(lab, first, variants, right_m=20, hows=("walks", "default")):
    """A table with a line per variant (name, keywords of lab.answers), and the answers by line for each method."""
    rows, answers = [[first, "vertices", *(f"{how}, all" for how in hows), "walks, surest fifth", "walks, area"]], {}
    for (name, _), found in lab.each([(f"{first}: {n}", k) for n, k in variants],
                                     lambda v: [lab.answers(how=how, **v[1]) for how in hows]):
        name, walks = name.split(": ")[1], found[0]
        answers[name] = found
        rows.append([name, f"{statistics.median(a.vertices for a in walks):.0f}", *(with_interval(a, right_m) for a in found),
                     percent(success(surest(walks, 5), right_m)), f"{area(precision_recall(walks, right_m)):.2f}"])
    return rows, answers


def by_default(lab):
    """The default has a graph of its own, which the settings of the paper do not touch."""
    share = success(lab.answers("synthia", "default"), lab.worlds["synthia"].right_m)
    return share, f"Today's default, which these settings do not touch, finds {percent(share)} of the same windows.\n\n"


def query_length(lab):
    lengths = [5, 15] if lab.arguments.quick else [5, 10, 15, 25, 30]
    rows, found = compared(lab, "query [m]", [(2 * frames, {"name": "synthia", "window": frames}) for frames in lengths])
    xs = [int(name) for name in found]
    if len(xs) < 2:
        raise NotRun
    said = trend(f"longer queries are found more often ({xs[-1]} against {xs[0]} m)", (found[str(xs[-1])][0], 20),
                 (found[str(xs[0])][0], 20))
    curves = [Curve(how, [(x, 100 * success(found[str(x)][i], 20)) for x in xs], color)
              for i, (how, color) in enumerate((("walks", ORANGE), ("default", BLUE)))]
    return "Length of the query", {"length": chart("Length of the query, SYNTHIA-like", "metres travelled",
                                                   "within 20 m [%]", curves, xs)}, said + table(rows)


def coarseness(lab):
    variants = [(metres, {"name": "synthia", "graph": merging(metres)}) for metres in (5, 10, 15)]
    rows, found = compared(lab, "merge distance [m]", variants, hows=("walks",))
    distances = [int(name) for name in found]
    if len(distances) < 3:
        raise NotRun
    default, said = by_default(lab)
    curves = [Curve("walks", [(x, 100 * success(found[str(x)][0], 20)) for x in distances], ORANGE),
              Curve("default", [(x, 100 * default) for x in distances], BLUE, True)]
    claims = "".join(trend(f"10 m is best on SYNTHIA (10 against {other} m)", (found["10"][0], 20), (found[str(other)][0], 20))
                     for other in (5, 15))
    return "Coarseness of the graph", {"coarseness": chart("Merge distance, SYNTHIA-like", "merge distance [m]",
                                                           "within 20 m [%]", curves, distances)}, claims + said + table(rows)


def merging(metres):
    """Edges reach further in proportion, as in the presets."""
    return () if metres == 10 else ("--merge.first_observation_m", str(metres), "--edges.radius_m", str(1.2 * metres))


def spaces(lab):
    image = ("--graph_space", "image")
    variants = [("3-D in 3-D", {}), ("image in image", {"graph": image}), ("image in 3-D", {"graph": image, "graph_of_map": ()}),
                ("3-D in image", {"graph_of_map": image})]
    rows, found = compared(lab, "query in map", [(name, {"name": "synthia", **flags}) for name, flags in variants],
                           hows=("walks",))
    if len(found) < 2:
        raise NotRun
    said = trend("edges by distance in space do better than edges in images", (found["3-D in 3-D"][0], 20),
                 (found["image in image"][0], 20))
    said += by_default(lab)[1] + "The paper also matches a graph of one space against a map of the other; the last rows do.\n\n"
    return "Image space, 3-D space, and across", {}, said + table(rows)


def class_sets(lab):
    rows, _ = compared(lab, "classes", [(count, {"name": "synthia", "classes": count}) for count in (8, 6, 5)])
    said = ("The sets that the paper uses on its three data sets, in these towns. Their hedges are vegetation, which leaves "
            "the set of 6 one class fewer.\n\n")
    return "Sets of classes", {}, said + table(rows)


def season(lab):
    variants = [(name, {"name": "synthia", "session": session, "classes": 8})
                for name, session in (("another day", "forward2"), ("another season", "winter"))]
    rows, _ = compared(lab, "the drive on", variants)
    said = "In the other season every tree, hedge and sign is gone, and nobody is about.\n\n"
    return "Season", {}, said + table(rows)


TIMES = """Median (mean ± deviation) over the windows, wall time of one thread; the paper's core was a Xeon E3-1226. What else ran on the machine is in them: others
used its two cores, so they bound costs from above. The paper builds and merges the graph anew with every frame; here a window is built once, so its cost is given per frame. Reading the images is not counted.

"""
PAPER_MS = {"construction of the query graph, per frame": (337, 257), "walks": (1.38, None), "matching": (7.30, None),
            "pose (back-end)": (22.5, None)}
STAGES = {"construction of the query graph, per frame": ("lift", "blobs", "graph"), "walks": ("descriptors",),
          "matching": ("matching",), "rejection": ("rejection",), "pose (back-end)": ("pose", "posterior", "refine")}


def timing(lab):
    """Without the first window, in which the descriptors of the map are made."""
    columns = [(name, how) for name in ("synthia", "airsim") if name in lab.worlds for how in ("walks", "default")]
    rows = [["stage [ms]", "paper, SYNTHIA / AirSim", *(f"{how}, {NAMES[name].split(',')[0]}" for name, how in columns)]]
    for stage, parts in STAGES.items():
        cells = []
        for name, how in columns:
            frames = lab.worlds[name].window if "per frame" in stage else 1
            ms = [sum(a.timing_ms.get(part, 0) for part in parts) / frames for a in lab.answers(name, how)[1:]]
            cells.append(f"{statistics.median(ms):.2f} ({statistics.mean(ms):.2f} ± {statistics.stdev(ms):.2f})"
                         if len(ms) > 1 else "–")
        paper = " / ".join("–" if v is None else f"{v:g}" for v in PAPER_MS.get(stage, (None, None)))
        rows.append([stage, paper, *cells])
    return "Times", {}, TIMES + table(rows)


def bag_of_words(lab):
    return "Bag of words", {}, """The paper compares with bags of words and NetVLAD on colour images, which reach up to 75 %. Neither is run here. The simulator renders depth, classes and
instances, and no colours: the corners of ORB or SIFT would lie in textures and shadows of our own making, so the outcome would be ours to choose, and on pictures of the classes such a
baseline would be given perfect labels that it does not have in the paper."""


DISTANCES_M = [0.1 * 1.2 ** i for i in range(39)]


def page_text(lab, results):
    parts = [INTRODUCTION]
    for heading, charts, said in results:
        parts.append(f"## {heading}")
        parts += [f"![{heading}: {name}](paper_{name}.svg)" for name in charts]
        parts.append(said)
    if lab.missing:
        parts.append("## Not run\n\nMissing in the figures above: " + "; ".join(dict.fromkeys(lab.missing)) + ".")
    return wrapped("\n\n".join(parts))


INTRODUCTION = """# The paper's experiments

Written by `./run paper` (`--help`). It repeats the experiments of X-View (RA-L 2018) with settings inside the paper's text,
`config/paper/*.yaml` and `config/labels/paper_*.yaml` (*walks*), with every walk counted by its probability instead of 200 drawn ones (*exact*), and with today's
default on the same recordings (*default*, all classes unless a column says otherwise). What is broken off goes on where it stopped.

**What of X-View carries, and what does not.** The idea carries: walks over class labels propose enough right pairs that one pose explains far more of them than chance, from another view,
with labels alone. Three things decide whether that is seen: pairs must be drawn that agree with one another (blind draws of three of a thousand pairs of which one in a hundred is right hit nothing),
the counts of walks must be kept, and only queries with a consensus may count, as in the paper. What does not carry is one answer for every query: with noisy labels or few classes most vertices lose
their own counterpart among hundreds of similar ones, and the agreement of vertices cannot tell; today's default asks all of what was seen, not only the vertices.

**The data is rendered.** Neither SYNTHIA, AirSim nor StreetView is used: towns of our own simulator stand in for them, with the length of the drive, the view and the spacing of frames
of the paper, and a second camera of the same car that looks back. A number here is no verdict on the paper's numbers. Images are smaller (480 x 285 instead of 1280 x 760 pixels). Hedges are
a class of their own from the air, as in AirSim; otherwise they are vegetation.

* *within 20 m* (30 m for AirSim, as in the paper): the best hypothesis of a window is as near as that to the true position of its last frame, whether it is accepted or not. Queries of 30 m (StreetView: 60 m)
  unless said; [ ] are 95 % intervals of Wilson. *Along x only* is how the scripts that came with the paper measure.
* The consensus value s of a query is the tightest tolerance [m] at which more than six vertices agree; it is accepted if s <= t_c. Recall counts all queries. *area* is that under precision over recall.
* *surest fifth*: those scripts drop localizations by their consensus until a fifth is left; the paper's figures are success at such an operating point.
* Four towns (two suburbs, a village, a grid of equal streets) on which nothing was chosen. k = 30 (60 from the air), edges of 1.2 times the merge distance and tolerances of 3 m (2 m from the air) are not in the paper; they were
  chosen on other towns."""

EXPERIMENTS = (localization, precision, query_length, coarseness, spaces, class_sets, season, timing, bag_of_words)


def arguments_of():
    root = Path(__file__).resolve().parent.parent
    what, how = __doc__.split("\n\n", 1)
    parser = argparse.ArgumentParser("run paper", description=what, epilog=how)
    add = parser.add_argument
    add("--program", type=Path, metavar="PATH", default=root / "build/xview", help="default: that of build/")
    add("--work", type=Path, metavar="DIR", default=root / "paper", help="where worlds and runs are kept; default paper/")
    add("--out", type=Path, metavar="DIR", default=root / "docs", help="folder of paper.md and its charts; default docs/")
    add("--jobs", type=int, default=2, metavar="N", help="experiments at a time, of one thread each; default 2")
    add("--stored", action="store_true", help="run nothing: the page from the runs that there are; it says what is missing")
    add("--quick", action="store_true", help="all of it in one tiny world, to see that it runs; needs --out")
    arguments = parser.parse_args()
    if arguments.quick and arguments.out == root / "docs":
        parser.error("--quick says nothing about the paper; give it another --out")
    arguments.program, arguments.work = arguments.program.resolve(), arguments.work.resolve()
    return arguments


def main():
    arguments = arguments_of()
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    lock = open(arguments.work / "lock", "w")
    if not arguments.stored:
        fcntl.flock(lock, fcntl.LOCK_EX)  # A second run waits for its turn in the same folder.
    lab = Lab(arguments)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        if not arguments.stored:  # Experiments begin with the same worlds, and would wait for one another.
            list(pool.map(lambda place: lab.folder(*place), [(name, town) for name in lab.worlds for town in lab.towns]))
        made = [pool.submit(experiment, lab) for experiment in EXPERIMENTS]
    results = []
    for experiment, result in zip(EXPERIMENTS, made):
        try:
            results.append(result.result())
        except NotRun:
            lab.missing.append(experiment.__name__.replace("_", " "))
    for _, charts, _ in results:
        for name, svg in charts.items():
            write_whole(arguments.out / f"paper_{name}.svg", svg)
    write_whole(arguments.out / "paper.md", page_text(lab, results))
    print(arguments.out / "paper.md")
    if arguments.quick and success(lab.answers("synthia", "default"), 1) < 0.5:
        sys.exit("the default does not find its way in the tiny world")


if __name__ == "__main__":
    main()
