#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Answers of localize in many simulated worlds, one line each, with their evidence and whether they are right.

Worlds of five styles with labels of several qualities, from as many seeds as are asked for, are mapped. Windows of
several lengths of their other sessions, of a place elsewhere and of the next seeds' worlds are localized. The table
shows how far the confidence can be trusted, a summary of it is printed, and `xview learn --verdict` can be fed with
the answers themselves (--answers). Styles of OTHER_STYLES are worlds of another make, by bench/other_worlds, which
shares no code with the program; their labels have one quality. With --sequence all windows of a camera session speak
together, each half a window after the last. Worlds and runs are kept in --work, so that a check that was broken off
goes on where it stopped; the table is written anew after every world.
"""
import argparse
import csv
import io
import json
import math
import os
import subprocess
import sys
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
import paper_page as page
import regress_worlds as worlds
from regress import Runner, checked, simulated, write_whole

STYLES = ("suburb", "grid", "village", "campus", "office")
QUALITIES = (0.83, 0.68, 1.0, 0.6)  # Share of the pixels with the right label; 1 = perfect sensors.
OTHER_STYLES = ("forest", "oldtown", "motorway", "village_slope", "carpark", "warehouse", "home")
OTHER_QUALITY = 0.88
LENGTHS_M = {"office": ((5, 10), (10, 20)), "home": ((2, 8), (4,)), "warehouse": ((10, 40), (20,))}
LENGTHS_OUTDOORS_M = ((8, 30, 100), (15, 60))  # Sessions take turns.
SEQUENCE_M = {"office": 8, "home": 4, "warehouse": 20}  # Of windows that speak together.
SEQUENCE_OUTDOORS_M = 15
SESSIONS = ("rear", "oblique", "aerial", "forward2", "elsewhere")
OF_OTHER_WORLD = (("rear", "forward"), ("oblique", "forward"), ("aerial", "forward"), ("lidar_reverse", "lidar"))
RIGHT_M = {"office": 0.5, "home": 0.5, "warehouse": 1.0}
RIGHT_OUTDOORS_M = 3.0

World = namedtuple("World", "style seed quality")
COLUMNS = ["style", "seed", "quality", "session", "window_m", "first_frame", "stranger", "right", "error_m", "status",
           "confidence"]


def is_alike(seed):
    """Every third seed has streets or rooms that are copies of a few."""
    return seed % 3 == 1


def name_of(world):
    return f"{world.style}_{world.seed}_{world.quality:g}"


def flags_of(world, lidar):
    flags = ["--seed", str(world.seed), "--sim.style", world.style, "--sessions.forward2", "--sessions.oblique",
             "--sessions.elsewhere", "--threads", "1"]
    if world.style != "office":
        flags += ["--route_length_m", "160"]
    if is_alike(world.seed):
        flags += ["--sim.alike", "0.7"]
    if lidar:
        flags += ["--sessions.lidar", "--lidar.azimuths", "512", "--lidar.rings", "32"]
    if world.quality < 1:
        flags += ["--quality", "noisy", "--label_noise.accuracy", str(world.quality),
                  "--drift", "0.02" if world.quality < 0.8 else "0.01"]
    return flags


def of_another_make(program, work, world):
    """The folder of a world of OTHER_STYLES, made once."""
    folder = work / "worlds" / name_of(world)
    if not folder.exists():
        part = folder.with_name(f"{folder.name}.{os.getpid()}")
        subprocess.run([str(program), world.style, str(world.seed), str(part)], check=True)
        part.replace(folder)
    return folder


def windows(folder, metres, count, sequence=False):
    """Flags for about `count` windows of this length, or None if the recording is shorter."""
    frames = len(worlds.frame_numbers(folder))
    size = max(1, round(metres / max(1e-3, worlds.metres_per_frame(folder))))
    if size > frames:
        return None
    if sequence:
        return ["--window", str(size), "--stride", str(size // 2), "--sequence"]
    return ["--window", str(size), "--stride", str(max(1, (frames - size) // max(1, count - 1)))]


def jobs_of(world, folders, arguments):
    """Runs of one world: session, length, queries, truth or None, name of the map's session."""
    lengths = LENGTHS_M.get(world.style, LENGTHS_OUTDOORS_M)
    at = arguments.seeds.index(world.seed)
    next_seeds = (arguments.seeds[at + 1:] + arguments.seeds[:at])[:arguments.others]
    candidates = [(session, folders[world] / session, session != "elsewhere", "forward") for session in SESSIONS]
    candidates += [(session, folders[world] / session, session != "lidar_elsewhere", "lidar")
                   for session in ("lidar_reverse", "lidar_elsewhere")]
    candidates += [(f"{seed} {session}", folders[world._replace(seed=seed)] / session, False, mapped)
                   for seed in next_seeds for session, mapped in OF_OTHER_WORLD]
    candidates.append(("aerial_elsewhere", folders[world] / "aerial_elsewhere", False, "forward"))
    for turn, (session, folder, in_map, mapped) in enumerate(candidates):
        if not folder.is_dir() or not (folders[world] / mapped).is_dir():
            continue
        if arguments.sequence and (turn >= len(SESSIONS) or session == "aerial"):
            continue
        together_m = SEQUENCE_M.get(world.style, SEQUENCE_OUTDOORS_M)
        for metres in (together_m,) if arguments.sequence else arguments.metres or lengths[(turn + world.seed) % len(lengths)]:
            flags = windows(folder, metres, arguments.windows, arguments.sequence)
            if flags:
                truth = worlds.true_poses(folder) if in_map else None
                yield session, metres, worlds.Part(worlds.Map([folders[world] / mapped], []), [folder], flags, truth)


def flat(value, name=""):
    """The numbers of an answer by a name each: lists become name_1, name_2; poses and times are left out."""
    if isinstance(value, (bool, int, float)):
        return {name: int(value) if isinstance(value, bool) else value}
    found = {}
    if isinstance(value, dict):
        for key, part in value.items():
            if key not in ("query", "pose", "T_map_query", "covariance", "timing_ms", "trajectory", "confidence"):
                found.update(flat(part, f"{name}_{key}" if name else key))
    if isinstance(value, list) and all(isinstance(part, dict) for part in value):
        for number, part in enumerate(value[:3], 1):
            found.update(flat(part, f"{name}_{number}"))
    return found


def line_of(world, session, metres, answer, truth):
    error = math.inf
    if truth and answer.get("pose"):
        T = truth(answer)
        error = math.dist([T[i][3] for i in range(3)], answer["pose"]["position"])
    right = error <= RIGHT_M.get(world.style, RIGHT_OUTDOORS_M)
    line = {"style": world.style, "seed": world.seed, "quality": world.quality, "session": session,
            "window_m": metres, "first_frame": answer["query"]["first_frame"], "stranger": int(truth is None),
            "right": int(right), "error_m": round(error, 3), "status": answer["status"],
            "confidence": answer.get("confidence", 0)}
    return {**line, **flat(answer)}


def lines_of(world, folders, runner, arguments):
    lines = []
    for session, metres, part in jobs_of(world, folders, arguments):
        run, mapped = runner.localize(part, [], [])
        if run is None:
            print(f"{name_of(world)} cannot be mapped: {mapped['said']}", file=sys.stderr)
            return lines
        answers = [a for a in run["answers"] if a["status"] != "error"]
        found = [line_of(world, session, metres, a, part.truth) for a in answers]
        lines += found
        if arguments.answers:
            with open(arguments.answers / f"{name_of(world)}.jsonl", "a") as file:
                file.writelines(checked(answer, line["error_m"], RIGHT_M.get(world.style, RIGHT_OUTDOORS_M), world.style)
                                for answer, line in zip(answers, found))
    return lines


BANDS = (0, 0.5, 0.9, 0.98, 0.999, 1.0001)  # Of confidence.
Band = namedtuple("Band", "low high answers said right")


def bands(lines):
    """How many answers of each band of confidence there are, what they say on average and how many are right.

    Confidence is that share if every other query is out of the map, so all negatives together weigh as much as all
    windows of the place.
    """
    strangers = sum(line["stranger"] for line in lines)
    weight = (len(lines) - strangers) / strangers if strangers else 1
    for low, high in zip(BANDS, BANDS[1:]):
        band = [line for line in lines if low <= line["confidence"] < high]
        if band:
            weights = [weight if line["stranger"] else 1 for line in band]
            yield Band(low, min(high, 1), len(band), *(
                sum(w * line[key] for w, line in zip(weights, band)) / sum(weights) for key in ("confidence", "right")))


def picture(lines):
    """Right answers over what their confidence says, both evenly in log odds."""
    def log_odds(share):
        return math.log10(share / (1 - share))

    def spread(band):
        """Where the true share lies with 95 %: Wilson."""
        n, z = band.answers, 1.96
        centre = (band.right + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(band.right * (1 - band.right) / n + z * z / (4 * n * n))
        return centre - half, centre + half

    width, height, ticks = 460, 400, (0.01, 0.1, 0.5, 0.9, 0.99, 0.999)
    end = log_odds(0.9996)
    x, y = page.Axis(-end, end, 60, width - 20), page.Axis(-end, end, height - 50, 50)
    place = lambda axis, share: axis(log_odds(min(max(share, 1 - 0.9996), 0.9996)))
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
             f'height="{height}" font-family="sans-serif" fill="#222">',
             f'<rect width="{width}" height="{height}" fill="white"/>',
             page.text(20, 26, "Right answers, and what confidence claims", "start", 15, 'font-weight="bold"'),
             page.text((40 + width) / 2, height - 12, "confidence"),
             page.text(18, height / 2, "right, with 95 % interval", more=f'transform="rotate(-90 18 {height / 2})"')]
    for share in ticks:
        parts += [page.line(x(-end), place(y, share), x(end), place(y, share), "#dddddd"),
                  page.line(place(x, share), y(-end), place(x, share), y(end), "#dddddd"),
                  page.text(place(x, share), y(-end) + 18, f"{share:g}"),
                  page.text(x(-end) - 6, place(y, share) + 4, f"{share:g}", "end")]
    parts.append(page.line(x(-end), y(-end), x(end), y(end), page.GREY, 'stroke-dasharray="5 4"'))
    for band in bands(lines):
        at, (low, high) = place(x, band.said), spread(band)
        parts += [page.line(at, place(y, low), at, place(y, high), page.BLUE, 'stroke-width="2"'),
                  f'<circle cx="{at:.1f}" cy="{place(y, band.right):.1f}" r="5" fill="{page.BLUE}"/>',
                  page.text(at - 9, place(y, band.right) - 8, f"{band.answers} answers", "end", 11)]
    return "\n".join([*parts, "</svg>", ""])


def summary(lines):
    """Whether answers are right as often as they say, and what is accepted, by style and quality."""
    for band in bands(lines):
        yield (f"confidence {band.low:5.3f} to {band.high:5.3f}: {band.answers:5d} answers say {band.said:.3f}, "
               f"{band.right:.3f} are right")
    for style, quality in sorted({(line["style"], line["quality"]) for line in lines}):
        here = [line for line in lines if (line["style"], line["quality"]) == (style, quality)]
        own, strangers = ([line for line in here if line["stranger"] == kind] for kind in (0, 1))
        accepted = [line for line in own if line["status"] == "accepted"]
        yield (f"{style} {quality:g}: {len(own)} windows, {sum(line['right'] for line in own)} right, {len(accepted)} "
               f"accepted, of these {sum(not line['right'] for line in accepted)} wrong; {len(strangers)} strangers, "
               f"{sum(line['status'] == 'accepted' for line in strangers)} accepted")


def places(lines):
    """(name, lines) of usual places and of such that are copies, by label quality."""
    for indoors in (False, True):
        for alike in (False, True):
            for quality in sorted({line["quality"] for line in lines}, reverse=True):
                here = [line for line in lines if (line["style"] in LENGTHS_M, is_alike(int(line["seed"])),
                                                   line["quality"]) == (indoors, alike, quality)]
                if here:
                    yield f"{'rooms' if indoors else 'towns'}{' of copies' if alike else ''}, {quality:.0%}", here


def markdown(lines):
    """Tables for docs/results/verdict.md: by place and length of window, and by confidence."""
    for indoors in (False, True):
        chosen = [(name, here) for name, here in places(lines) if (here[0]["style"] in LENGTHS_M) == indoors]
        if not chosen:
            continue
        lengths = sorted({int(line["window_m"]) for _, here in chosen for line in here})
        yield "| right, accepted of | " + " | ".join(f"{m} m" for m in lengths) + " | negatives accepted |"
        yield "|---" * (len(lengths) + 2) + "|"
        for name, here in chosen:
            cells = []
            for metres in lengths:
                own = [line for line in here if int(line["window_m"]) == metres and not line["stranger"]]
                accepted = sum(line["status"] == "accepted" for line in own)
                cells.append(f"{sum(line['right'] for line in own)}, {accepted} of {len(own)}" if own else "-")
            strangers = [line for line in here if line["stranger"]]
            accepted = sum(line["status"] == "accepted" for line in strangers)
            yield f"| {name} | " + " | ".join(cells) + f" | {accepted} of {len(strangers)} |"
        yield ""
    yield "| confidence | answers | says | right |"
    yield "|---|---|---|---|"
    for band in bands(lines):
        yield f"| {band.low:g} to {band.high:g} | {band.answers} | {band.said:.3f} | {band.right:.3f} |"


def save(file, lines):
    columns = COLUMNS + sorted({key for line in lines for key in line} - set(COLUMNS))
    text = io.StringIO()
    table = csv.DictWriter(text, columns, lineterminator="\n")
    table.writeheader()
    table.writerows(lines)
    write_whole(file, text.getvalue())


def stored(table):
    """The lines of a table, with numbers where the summary needs them."""
    with open(table, newline="") as file:
        lines = list(csv.DictReader(file))
    for line in lines:
        for key, number in (("quality", float), ("confidence", float), ("right", int), ("stranger", int)):
            line[key] = number(line[key])
    return lines


def measured(arguments):
    """Runs all worlds and writes their lines to the table."""
    if arguments.answers:
        arguments.answers.mkdir(parents=True)
    arguments.program, arguments.work = arguments.program.resolve(), arguments.work.resolve()
    runner = Runner(arguments.program, arguments.work)
    chosen = [World(style, seed, quality) for seed in arguments.seeds for quality in arguments.qualities
              for style in arguments.styles if style in STYLES]
    chosen += [World(style, seed, OTHER_QUALITY) for seed in arguments.seeds for style in arguments.styles
               if style in OTHER_STYLES]

    def made(world):
        if world.style in OTHER_STYLES:
            return of_another_make(arguments.program.parent / "bench/other_worlds", arguments.work, world)
        lidar = world.quality == 0.83 and world.style != "office" and world.seed % 2 == 1
        return simulated(arguments.program, arguments.work, name_of(world), flags_of(world, lidar))

    with ThreadPoolExecutor(arguments.jobs) as pool:
        folders, lines = dict(zip(chosen, pool.map(made, chosen))), []
        for world, found in zip(chosen, pool.map(lambda w: lines_of(w, folders, runner, arguments), chosen)):
            lines += found
            save(arguments.table, lines)
            print(f"{name_of(world)}: {len(lines)} lines", file=sys.stderr)
    return lines


def main():
    root = Path(__file__).resolve().parent.parent
    what, how = __doc__.split("\n\n", 1)
    parser = argparse.ArgumentParser(description=what, epilog=how)
    add = parser.add_argument
    add("table", type=Path, metavar="TABLE.csv", help="written anew after every world")
    add("--program", type=Path, default=root / "build/xview", help="default: that of build/")
    add("--work", type=Path, default=root / "verdict", help="where worlds and runs are kept; default verdict/")
    add("--seeds", type=int, nargs="+", default=list(range(1, 11)), help="default: 1 to 10")
    add("--styles", nargs="+", default=STYLES, choices=STYLES + OTHER_STYLES)
    add("--qualities", type=float, nargs="+", default=QUALITIES)
    add("--others", type=int, default=1, help="other seeds whose sessions are strangers to a world; default 1")
    add("--windows", type=int, default=6, help="of each length and session; default 6")
    add("--metres", type=int, nargs="+", metavar="M", help="lengths of all windows, 0 for single frames; default: those of the style")
    add("--sequence", action="store_true", help="all windows of a camera session together, of one length")
    add("--jobs", type=int, default=2, help="worlds at a time, of one thread each; default 2")
    add("--picture", type=Path, metavar="FILE.svg", help="draw whether answers are right as often as they say")
    add("--stored", action="store_true", help="run nothing: summary and picture of TABLE.csv as it is")
    add("--markdown", action="store_true", help="print tables for docs/results/verdict.md instead of the summary")
    add("--answers", type=Path, metavar="DIR", help="a new folder for the answers, one .jsonl per world")
    arguments = parser.parse_args()
    lines = stored(arguments.table) if arguments.stored else measured(arguments)
    if arguments.picture:
        write_whole(arguments.picture, picture(lines))
    print(*(markdown if arguments.markdown else summary)(lines), sep="\n")


if __name__ == "__main__":
    main()
