#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes docs/results/: the overview, the table of worlds and the plots, from the runs of `./run regress`.

Takes the arguments of bench/regress.py; what that has run already is not run again. Shares have 95 % intervals (Wilson).
"""
import datetime
import sys
from collections import namedtuple
from pathlib import Path

sys.dont_write_bytecode = True
import regress
import regress_worlds as worlds
from paper import wilson
from paper_page import BLUE, GREY, ORANGE, Curve, chart, table, wrapped

PAGES = Path(__file__).resolve().parent.parent / "docs/results"
KINDS = ("cameras in streets", "LiDAR", "from the air", "depth cameras in rooms and on desks", "bare graphs")
BANDS = [0, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999, 1]
MADE = "Written by `./run results` on {} from {} queries of the place and {} negatives; do not edit."

Answer = namedtuple("Answer", "row kind confidence accepted right stranger")


def with_interval(right, count):
    if count == 0:
        return "–"
    low, high = wilson(right / count, count)
    return f"{100 * right / count:.4g} [{100 * low:.3g}–{100 * high:.3g}]"


def kind_of(row):
    streets, aerial, rooms = KINDS[0], KINDS[2], KINDS[3]
    if row.world in ("osm", "pole_maps"):
        return "bare graphs"
    if "aerial" in row.session or row.world.startswith("als"):
        return aerial
    if row.world.startswith(("office", "tum", "rgbd", "rooms", "mosd")):
        return rooms
    cameras = ("suburb", "grid", "village", "own_clean", "own_noisy", "raw_suburb")
    return streets if row.world.startswith(cameras) else "LiDAR"


def answers_of(row, runner):
    kind = kind_of(row)
    for part in row.parts:
        run, _ = runner.localize(part, [], [])
        for answer in run["answers"] if run else []:
            if answer["status"] == "error":
                continue
            right = part.truth is not None and regress.error_and_nees(answer, part.truth)[0] <= row.wrong_m
            yield Answer(row, kind, answer["confidence"], answer["status"] == "accepted", right, part.truth is None)


def overview(answers):
    rows = [["what looks", "queries", "right, %", "of these accepted, %", "wrong accepted", "negatives accepted"]]
    for kind in (*KINDS, "all"):
        own = [a for a in answers if kind in (a.kind, "all") and not a.stranger]
        strangers = [a for a in answers if kind in (a.kind, "all") and a.stranger]
        right = [a for a in own if a.right]
        rows.append([kind, len(own), with_interval(len(right), len(own)), with_interval(sum(a.accepted for a in right), len(right)),
                     sum(a.accepted and not a.right for a in own),
                     f"{sum(a.accepted for a in strangers)} of {len(strangers)}" if strangers else "–"])
    return table(rows)


def reliability(answers):
    """What answers of one band of confidence claim, and how many of them are right: a table, and a plot."""
    rows, points = [["confidence", "answers", "mean of what they say, %", "right, %"]], []
    for low, high in zip(BANDS, BANDS[1:]):
        band = [a for a in answers if low <= a.confidence and (a.confidence < high or high == 1)]
        if not band:
            continue
        said, right = sum(a.confidence for a in band) / len(band), sum(a.right for a in band)
        rows.append([f"{low:g} to {high:g}", len(band), f"{100 * said:.4g}", with_interval(right, len(band))])
        points.append((100 * said, 100 * right / len(band)))
    diagonal = Curve("as stated", [(0, 0), (100, 100)], GREY, True)
    plot = chart("Right over stated confidence", "stated, %", "right, %", [Curve("measured", points, BLUE), diagonal],
                 x_ticks=range(0, 101, 20), x_range=(0, 100))
    return table(rows), plot


def over_length(answers):
    """Of queries of cameras in streets, how many are accepted, over the length of the query: a plot."""
    labelled = [a for a in answers if not a.stranger and a.kind == KINDS[0] and not a.row.world.startswith("raw")]
    curves = []
    for name, color in (("clean", BLUE), ("noisy", ORANGE), ("poor", GREY)):
        points = []
        for length_m in (15, 30, 60):
            own = [a for a in labelled if a.row.world.endswith(name) and a.row.window == f"{length_m} m"]
            points += [(length_m, 100 * sum(a.accepted for a in own) / len(own))] if own else []
        if points:
            curves.append(Curve(name, points, color))
    return chart("Accepted over the length of the query", "length, m", "accepted, %", curves, x_ticks=(15, 30, 60), x_range=(10, 65))


OVERVIEW = """# Results

{made}

{overview}

*Right*: the best place is within 5 m outdoors, 0.5 m in rooms, 0.15 m on a desk, accepted or not; most are within
centimetres ([worlds](worlds.md)). *Wrong accepted*: farther off, and accepted all the same. *Negatives*: out-of-map
queries, which must be refused. Accepted means wrong with a chance of at most 1 % (`--risk`). The verdict was
learned from windows of these worlds, each recording judged by weights that the others set ([verdict](verdict.md));
worlds that set nothing are in [studies](studies.md).

## Does the confidence mean what it says?

Every second query would be a negative if the figures were exact; here {share:.0f} % are.

![right over stated confidence](reliability.svg)

{reliability}

## How long must a query be?

Cameras in streets with labels, looking ahead, back or aside; *noisy*: 83 % of the labels right and stereo depth; *poor* is the village, whose labels are right in 68 % of the pixels.

![accepted over length](length.svg)

## Pages

| question | page |
|---|---|
| How near is the pose in every world, clean, noisy and real? What does a query cost? | [worlds](worlds.md) |
| And PCL's own registration, on the same raw clouds? | [against PCL](against_pcl.md) |
| And Open3D, with rooms, whole processes? | [against Open3D](against_open3d.md) |
| Who decides what is accepted, and on what was that learned? | [verdict](verdict.md) |
| Worlds of another make, raw clouds, label sets, bare graphs, from the air, what the parts add | [studies](studies.md) |
| What does a map cost as it grows, and does it find less? | [growth](growth.md) |
| Do maps find one another, is what changed told, and do added drives spoil a map? | [life](life.md) |
| Is a robot that was carried away found again, and how fast is a frame? | [live](live.md) |
| How fast does a page draw, how large may a map be? | [time and memory](time.md) |
| X-View as published, and its walks | [paper](../paper.md) |
| What is promised, and which test holds it | [reliability](../reliability.md) |
"""

WORLDS = """# Every world that has truth

{made}

`./run regress` maps, localizes and judges every world of `../shared/data` and three seeded ones of our own (`own_*`);
`raw_*` are recordings whose labels were withheld, `real_strangers` every real recording in the maps of the others. It
keeps what was run already in `regress/`, and fails if a row is worse than in `bench/regress_baseline.csv`, which has a
line per session; here sessions are summed. *Within*: error of the best place, accepted or not. *Wrong*: accepted, but
5 m off outdoors, 0.5 m in a room, 0.15 m on a desk. *NEES / 6*: mean normalised error squared of right accepted poses,
1 if the covariance is right.

{worlds}
Not held out: the likelihoods were learned on `suburb_noisy`, the registration was fitted on both suburbs and on
simulated seeds, the verdict on windows of these worlds, each judged by weights that the others set
([verdict](verdict.md)). Truth of `laser_teach_repeat` is known to 0.2 m and 1 degree, which is its NEES; by four pairs of
scans that say the same relative pose it is 0.5.
"""


def main():
    arguments = regress.arguments_of()
    rows, absent = regress.rows_to_check(arguments)
    runner = regress.Runner(arguments.program, arguments.work)
    lines, _ = regress.run_all(runner, rows, arguments)
    answers = [answer for row in rows for answer in answers_of(row, runner)]
    strangers = sum(a.stranger for a in answers)
    made = MADE.format(datetime.date.today(), len(answers) - strangers, strangers)
    bands, plot = reliability(answers)
    PAGES.mkdir(parents=True, exist_ok=True)
    (PAGES / "reliability.svg").write_text(plot)
    (PAGES / "length.svg").write_text(over_length(answers))
    page = OVERVIEW.format(made=made, overview=overview(answers), reliability=bands, share=100 * strangers / len(answers))
    (PAGES / "README.md").write_text(wrapped(page))
    worlds_table = regress.table_markdown(regress.by_world(lines))
    (PAGES / "worlds.md").write_text(wrapped(WORLDS.format(made=made, worlds=worlds_table)))
    if absent:
        print(f"without {', '.join(absent)}, which are not in {arguments.data}", file=sys.stderr)


if __name__ == "__main__":
    main()
