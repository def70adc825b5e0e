#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Maps, localizes and scores every world that has truth, one line each, and compares with a stored table.

Columns: n queries; of these so many within 0.1 to 5 m (best hypothesis, accepted or not) and the median error, both of
pose.position; accepted, of these wrong (5 m off outdoors, 0.5 m indoors, 0.15 m on a desk); accepted queries from
elsewhere; mean normalised error squared over 6 of the right accepted poses; medians of the stages in wall time; CPU
time and peak memory of localize; those and the size of the map.

Every run of the program is kept in --work by what it depends on: the bytes of the program and of its inputs, and its
flags. So a check that was broken off goes on where it stopped; scores are always computed anew. Wall times are not
compared, since other work on the machine is in them. Exit code 1 if something is worse than in the stored table.

Without further flags the answers of every query, without times, and digests of the maps are kept in --work/answers
by the commit that is checked out. --same COMMIT compares with those of another one, byte for byte; exit code 1 if any
differ. The program must be that of the commit: build it first.
"""
import argparse
import csv
import fcntl
import hashlib
import io
import json
import math
import os
import re
import shlex
import signal
import statistics
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
import regress_worlds as worlds
from regress_poses import from_quaternion, normalised_error_squared

LIMITS_M = (0.1, 0.3, 0.5, 1, 5)
RIGHT = [f"r{limit}" for limit in LIMITS_M]
STAGES = {"graph_ms": ("read", "lift", "blobs", "graph"), "search_ms": ("descriptors", "matching", "rejection"),
          "pose_ms": ("pose", "posterior"), "refine_ms": ("refine",), "total_ms": ("total",)}
KEYS = ["world", "session", "window"]
COLUMNS = KEYS + ["n", *RIGHT, "median_m", "accepted", "wrong", "strangers", "nees6", *STAGES, "cpu_s", "rss_mb",
                  "map_s", "map_cpu_s", "map_rss_mb", "map_mb", "inputs", "failed"]
HIDDEN = {"inputs", "failed", "map_cpu_s"}
CPU_LIMIT_S, WALL_LIMIT_S = 300, 3600  # Of a run; the longest one takes 25 s of CPU time.
SLACK_IN_ALL = 5  # So many queries fewer in the sum over all rows are worse, whatever the rows say.

# ---- Runs of the program ----

# The peak memory of a process counts that of the one it was begun by, so a small one begins them.
LAUNCHER = """
import os, resource, sys
limit = int(sys.argv[2])
resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
pid = os.posix_spawn(sys.argv[3], sys.argv[3:], os.environ)
_, status, usage = os.wait4(pid, 0)
open(sys.argv[1], "w").write(f"{usage.ru_utime + usage.ru_stime} {usage.ru_maxrss}")
code = os.waitstatus_to_exitcode(status)
os.kill(os.getpid(), -code) if code < 0 else sys.exit(code)
"""


def digest(*parts):
    return hashlib.sha256("\0".join(map(str, parts)).encode()).hexdigest()[:16]


class Runner:
    """Runs the program, each run once."""

    def __init__(self, program, work):
        self.program, self.runs, self.maps = program, work / "runs", work / "maps"
        self.version = hashlib.sha256(program.read_bytes()).hexdigest()
        self.bytes_of = {}
        for folder in (self.runs, self.maps):
            folder.mkdir(parents=True, exist_ok=True)

    def fingerprint(self, path):
        """Of the bytes of a file or of all files of a folder, and of the label set that may lie beside a file."""
        if path not in self.bytes_of:
            folder = path if path.is_dir() else path.parent
            files = sorted(folder.rglob("*")) if path.is_dir() else [path, folder / "classes.yaml"]
            seen = hashlib.sha256()
            for file in filter(Path.is_file, files):
                seen.update(f"{file.relative_to(folder)}\0".encode() + file.read_bytes())
            self.bytes_of[path] = seen.hexdigest()[:16]
        return self.bytes_of[path]

    def run(self, key, arguments):
        """Exit code, answers, seconds and peak memory of a run; a finished one is taken from its file."""
        file = self.runs / f"{key}.json"
        if file.exists():
            return json.loads(file.read_text())
        out, err = self.runs / f"{key}.out", self.runs / f"{key}.err"
        started = time.monotonic()
        used = self.runs / f"{key}.used"
        with open(out, "wb") as stdout, open(err, "wb") as stderr:
            process = subprocess.Popen([sys.executable, "-S", "-c", LAUNCHER, used, str(CPU_LIMIT_S), self.program,
                                        *map(str, arguments)], stdout=stdout, stderr=stderr, start_new_session=True)
            alarm = threading.Timer(WALL_LIMIT_S, os.killpg, (process.pid, signal.SIGKILL))
            alarm.start()
            code = process.wait()
            alarm.cancel()
        cpu_s, rss_kb = map(float, used.read_text().split()) if used.exists() else (math.nan, math.nan)
        used.unlink(missing_ok=True)
        result = {"code": code, "wall_s": time.monotonic() - started, "cpu_s": cpu_s,
                  "rss_mb": rss_kb / 1024, "said": err.read_text(errors="replace").splitlines()[-1:],
                  "answers": [json.loads(line) for line in out.read_text().splitlines() if line.endswith("}")]}
        if code >= 0:  # Neither out of time nor ended by somebody, which need not happen again.
            write_whole(file, json.dumps(result))
        out.unlink(), err.unlink()
        return result

    def map_key(self, place, extra):
        return digest("map", self.version, place.flags, extra, *map(self.fingerprint, place.inputs))

    def map(self, place, extra):
        key = self.map_key(place, extra)
        file = self.maps / f"{key}.xvm"
        result = self.run(key, ["map", *place.inputs, file, *place.flags, "--threads", "1", "--quiet", *extra])
        return file, {**result, "mb": file.stat().st_size / 1e6 if file.exists() else 0.0}

    def localize(self, part, extra, extra_map):
        """The run of localize and that of its map; without a map there is no run."""
        file, mapped = self.map(part.map, extra_map)
        if mapped["code"] != 0:
            return None, mapped
        queries = map(self.fingerprint, part.queries)
        key = digest("localize", self.map_key(part.map, extra_map), part.flags, extra, *queries)
        arguments = [*part.queries, file, *part.flags, "--json", "--threads", "1", "--quiet", *extra]
        return self.run(key, ["localize", *arguments]), mapped

    def inputs(self, row):
        return digest(*(self.fingerprint(path) for part in row.parts for path in [*part.map.inputs, *part.queries]))[:8]


def write_whole(file, text):
    part = file.with_name(file.name + f".{os.getpid()}")
    part.write_text(text)
    part.replace(file)


# ---- Scores ----


def error_and_nees(answer, truth):
    if not answer.get("pose"):
        return math.inf, math.inf
    T_true = truth(answer)
    T_estimate = from_quaternion(answer["pose"]["position"], answer["pose"]["quaternion"])
    error = math.dist([T_true[i][3] for i in range(3)], answer["pose"]["position"])
    return error, normalised_error_squared(answer["covariance"], T_estimate, T_true)


def reason_of(run):
    """Why a run failed, without folders, which differ from machine to machine."""
    said = re.sub(r"/\S*/", "", run["said"][-1].strip() if run["said"] else "no word")
    return f"code {run['code']}: {said}" if run["code"] >= 0 else f"signal {-run['code']}: {said}"


def score(row, runs):
    """The line of the table from [(localize run or None, map run)] of the parts of a row."""
    line = dict.fromkeys(COLUMNS, "")
    line.update(zip(KEYS, row))
    last = [localized or mapped for localized, mapped in runs]  # Without a map nothing was localized.
    failures = [reason_of(run) for run in last if run["code"] not in (0, 3)]
    line["failed"] = failures[0] if failures else ""
    mapped = [mapped for _, mapped in runs]
    line.update(map_s=sum(m["wall_s"] for m in mapped), map_cpu_s=sum(m["cpu_s"] for m in mapped),
                map_rss_mb=max(m["rss_mb"] for m in mapped), map_mb=sum(m["mb"] for m in mapped))
    answers = [(a, part) for part, (localized, _) in zip(row.parts, runs) if localized for a in localized["answers"]]
    # A graph that got no answer is one that was not found; windows that got none cannot be counted.
    unanswered = 0 if "--window" in row.parts[0].flags else sum(len(part.queries) for part in row.parts) - len(answers)
    line["n"] = len(answers) + unanswered
    localized = [run for run, _ in runs if run]
    if localized:
        line.update(cpu_s=sum(r["cpu_s"] for r in localized), rss_mb=max(r["rss_mb"] for r in localized))
    if answers:
        for column, stages in STAGES.items():
            line[column] = statistics.median(sum(a.get("timing_ms", {}).get(s, 0) for s in stages) for a, _ in answers)
    accepted = [a["status"] == "accepted" for a, _ in answers]
    if row.parts[0].truth is None:
        line["strangers"] = sum(accepted)
        return line
    scored = [error_and_nees(a, part.truth) for a, part in answers] + [(math.inf, math.inf)] * unanswered
    errors = [error for error, _ in scored]
    for column, limit in zip(RIGHT, LIMITS_M):
        line[column] = sum(error <= limit for error in errors)
    line["median_m"] = statistics.median(errors) if errors else math.inf
    line["accepted"] = sum(accepted)
    line["wrong"] = sum(not error <= row.wrong_m for error, yes in zip(errors, accepted) if yes)
    honest = [nees / 6 for (error, nees), yes in zip(scored, accepted) if yes and error <= row.wrong_m]
    line["nees6"] = statistics.mean(honest) if honest else ""
    return line


def checked(answer, error_m, right_m, make):
    """A line for `xview learn --verdict`: the answer, whether it is right and of which make; none if it is neither."""
    wrong_m = right_m if right_m < 1 else max(5, right_m)
    if right_m < error_m <= wrong_m or not answer.get("statistics", {}).get("registered"):
        return ""
    return json.dumps({**answer, "right": error_m <= right_m, "make": make}) + "\n"


def checked_answers(row, runs):
    """Those of a row; 3 m are right outdoors."""
    for part, (localized, _) in zip(row.parts, runs):
        for answer in localized["answers"] if localized else []:
            if answer["status"] != "error":
                error_m = error_and_nees(answer, part.truth)[0] if part.truth else math.inf
                yield checked(answer, error_m, min(3, row.wrong_m), row.world)


# ---- Comparison ----


def number(line, column):
    """Of a stored or a fresh line; None if there is none."""
    value = line.get(column, "")
    return None if value in ("", None) else float(value)


def changes(now, was):
    """What is better and what is worse than it was, beyond what chance and a busy machine do."""
    better, worse = [], []

    def count(column, slack, more_is_better):
        a, b = number(was, column), number(now, column)
        if a is not None and b is not None and abs(b - a) > slack:
            (better if (b > a) == more_is_better else worse).append(f"{column} {a:g}->{b:g}")

    def size(column, share, least, most_a=math.inf):
        """Less is better, and less than this share or so much in all is no change."""
        a, b = number(was, column), number(now, column)
        if a is None or b is None or min(a, b) > most_a or a == b:
            return
        if abs(b - a) > max(share * a, least):
            (better if b < a else worse).append(f"{column} {a:.3g}->{b:.3g}")

    if now["n"] != number(was, "n"):
        worse.append(f"n {was.get('n')}->{now['n']}")
    if bool(now["failed"]) != bool(was.get("failed")):
        (worse if now["failed"] else better).append("failed" if now["failed"] else "no longer failed")
    slack = 1 if now["n"] >= 10 else 0
    for column in RIGHT:
        count(column, slack, True)
    if (number(now, "wrong") or 0) >= (number(was, "wrong") or 0):  # To accept fewer wrong ones is no loss.
        count("accepted", slack, True)
    for column in ("wrong", "strangers"):
        count(column, 0, False)
    size("median_m", 0.1, 0.002, worlds.OUTDOORS_M)
    if min(number(line, "accepted") or 0 for line in (now, was)) >= 5:
        if max(number(line, "nees6") or 0 for line in (now, was)) > 1.5:
            size("nees6", 0.25, 0.1)
    size("cpu_s", 0.3, 0.5)
    size("rss_mb", 0.15, 10)
    size("map_cpu_s", 0.3, 0.5)
    size("map_mb", 0.1, 0.2)
    return better, worse


def verdict(now, was):
    """The last column, and -1 if the line is worse than it was, 1 if it is only better."""
    if was is None:
        return "new", 0
    if now["inputs"] != was["inputs"]:
        return "other inputs", 0
    better, worse = changes(now, was)
    said = [kind + ", ".join(what) for kind, what in (("worse: ", worse), ("better: ", better)) if what]
    return "; ".join(said), -1 if worse else 1 if better else 0


def totals(lines):
    """Sums over all rows; a row's slack of one query must not hide that many rows lose one."""
    columns = [*RIGHT, "accepted", "wrong", "strangers"]
    return {column: sum(int(line[column] or 0) for line in lines) for column in columns}


def compare(lines, baseline, expected):
    """Last column of every line, the lines of the summary, and whether anything is worse."""
    pairs = [(line, baseline.get(key_of(line))) for line in lines]
    verdicts = [verdict(now, was) if baseline else ("", 0) for now, was in pairs]
    marks, notes = [mark for _, mark in verdicts], [note for note, _ in verdicts]
    sums = totals(lines)
    strangers = sum(line["n"] for line in lines if line["strangers"] != "")
    said = [f"{len(lines)} rows, {sum(bool(line['failed']) for line in lines)} failed; "
            f"{sum(line['n'] for line in lines) - strangers} queries of the place, {strangers} strangers",
            "in all: " + ", ".join(f"{column} {value}" for column, value in sums.items())]
    if not baseline:
        return notes, said, False
    lost = [" ".join(key) for key in baseline if expected(key) and key not in set(map(key_of, lines))]
    said += [f"lost: {name}" for name in lost]
    said.append(f"{marks.count(-1)} rows worse, {marks.count(1)} better, {notes.count('new')} new, "
                f"{notes.count('other inputs')} with other inputs, {len(lost)} lost")
    both = [(now, was) for now, was in pairs if was and now["inputs"] == was["inputs"]]
    before, after = totals([was for _, was in both]), totals([now for now, _ in both])
    said.append("in all: " + (", ".join(f"{c} {before[c]}->{after[c]}" for c in sums if before[c] != after[c]) or "same"))
    fallen = any(before[column] - after[column] > SLACK_IN_ALL for column in [*RIGHT, "accepted"])
    return notes, said, fallen or bool(lost) or -1 in marks


# ---- Tables ----


def plain(column, value):
    """As stored: enough digits to compare, not more."""
    if not isinstance(value, float):
        return str(value)
    return f"{value:.4f}" if column in ("median_m", "nees6") else f"{value:.2f}"


def short(column, value):
    if not isinstance(value, float):
        return str(value)
    digits = {"median_m": 3, "nees6": 2}.get(column, 1)
    return f"{value:.{digits if value < 10 else 1 if digits > 1 else 0}f}"


def key_of(line):
    return tuple(line[key] for key in KEYS)


def read_table(file):
    with open(file, newline="") as stream:
        return {key_of(line): line for line in csv.DictReader(stream)}


def save_table(file, lines):
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerows([COLUMNS] + [[plain(column, line[column]) for column in COLUMNS] for line in lines])
    write_whole(file, text.getvalue())


def cells(line, note):
    last = "; ".join(filter(None, [f"failed: {line['failed']}" if line["failed"] else "", note]))
    return [short(c, line[c]) for c in COLUMNS if c not in HIDDEN] + [last]


def heading():
    return [c.replace("_", " ") for c in COLUMNS if c not in HIDDEN] + ["against the stored table"]


def table_text(rows):
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]

    def text(row):
        padded = [c.ljust(w) if i < len(KEYS) else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths))]
        return "  ".join(padded + row[-1:]).rstrip()

    return "\n".join(map(text, rows))


def table_markdown(rows):
    return "\n".join("| " + " | ".join(row) + " |" for row in [rows[0], ["---"] * len(rows[0]), *rows[1:]]) + "\n"


def by_world(lines):
    """The table in short: a line for all sessions of a world and a length of window."""
    table = [["world", "window", "queries"] + [f"within {limit} m" for limit in LIMITS_M] +
             ["accepted", "wrong", "negatives accepted", "NEES / 6", "CPU s per query"]]
    for world, window in dict.fromkeys((line["world"], line["window"]) for line in lines):
        here = [line for line in lines if (line["world"], line["window"]) == (world, window)]
        strangers = [line for line in here if line["strangers"] != ""]
        own = [line for line in here if line["strangers"] == ""]
        sums, refused = totals(own), sum(line["n"] for line in strangers)
        judged = [(line["accepted"] - line["wrong"], line["nees6"]) for line in own if line["nees6"] != ""]
        nees = sum(count * value for count, value in judged) / max(1, sum(count for count, _ in judged))
        cpu_s = sum(line["cpu_s"] or 0 for line in here) / max(1, sum(line["n"] for line in here))
        table.append([world, window, str(sum(line["n"] for line in own))] +
                     [str(sums[column]) if own else "" for column in [*RIGHT, "accepted", "wrong"]] +
                     [f"{totals(strangers)['strangers']} of {refused}" if strangers else "",
                      f"{nees:.2f}" if judged else "", f"{cpu_s:.2f}"])
    return table


# ---- Byte for byte ----

TIMES_AND_PATHS = ("timing_ms", "map")  # of an answer: what differs from run to run and from program to program
CHANGED = "-changed"


def commit_of(root, name="HEAD"):
    """Abbreviated; with a mark if HEAD was changed since."""
    def git(*words):
        return subprocess.run(["git", "-C", str(root), *words], check=True, capture_output=True, text=True).stdout.strip()
    commit = git("rev-parse", "--short=10", name)
    return commit + CHANGED if name == "HEAD" and git("status", "--porcelain", "--untracked-files=no") else commit


def kept_of(row, runs, runner, digests):
    """Of a row: digests of its maps, and each answer as text. `digests` has those that are known, by map file."""
    files = [runner.maps / f"{runner.map_key(part.map, [])}.xvm" for part in row.parts]
    for file in files:
        if file not in digests:  # Not its fingerprint, which has its name, and that is of the program.
            digests[file] = hashlib.sha256(file.read_bytes()).hexdigest() if file.exists() else ""
    answers = [answer for localized, _ in runs if localized for answer in localized["answers"]]
    return {"maps": [digests[file] for file in files],
            "answers": [json.dumps({k: v for k, v in answer.items() if k not in TIMES_AND_PATHS}) for answer in answers]}


def differing_keys(one, other):
    one, other = json.loads(one), json.loads(other)
    return [key for key in sorted({*one, *other}) if one.get(key) != other.get(key)]


def difference(now, was):
    """In words, empty if there is none."""
    said = []
    if now["maps"] != was["maps"]:
        said.append(f"{sum(a != b for a, b in zip(now['maps'], was['maps']))} of {len(now['maps'])} maps")
    pairs = list(zip(now["answers"], was["answers"]))
    changed = [(a, b) for a, b in pairs if a != b]
    if len(now["answers"]) != len(was["answers"]):
        said.append(f"{len(now['answers'])} answers, not {len(was['answers'])}")
    if changed:
        said.append(f"{len(changed)} of {len(pairs)} answers, the first in {', '.join(differing_keys(*changed[0]))}")
    return "; ".join(said)


def kept_at(commit, arguments):
    """The file of the answers of a commit."""
    folder = arguments.work / "answers"
    folder.mkdir(exist_ok=True)
    return folder / f"{commit}.json"


def keep(kept, arguments):
    """Beside rows that were kept of the same commit before."""
    commit = commit_of(arguments.root)
    file = kept_at(commit, arguments)
    before = json.loads(file.read_text()) if file.exists() and not commit.endswith(CHANGED) else {}
    write_whole(file, json.dumps({**before, **kept}))


def answers_to_compare(arguments):
    """Those that are kept of the commit of --same; None if none was asked for."""
    if not arguments.same:
        return None
    if arguments.extra or arguments.extra_map:
        sys.exit("--same compares what is kept, which is that without further flags")
    file = kept_at(commit_of(arguments.root, arguments.same), arguments)
    if not file.exists():
        sys.exit(f"{file}: no answers are kept of {arguments.same}; check it out, build it, and run this there first")
    return json.loads(file.read_text())


def all_same(kept, was, name):
    """Says which rows differ from those that were kept."""
    said = {key: difference(now, was[key]) if key in was else "not kept there" for key, now in kept.items()}
    differing = [f"differs: {key}: {words}" for key, words in said.items() if words]
    count = sum(len(row["answers"]) for row in kept.values())
    print(*differing, f"{len(kept)} rows, {count} answers: {len(differing)} rows differ from {name}", sep="\n")
    return not differing


# ---- The check ----


def simulated(program, work, name, flags):
    """The folder of a world of our own, made once, whatever program comes later."""
    folder = work / "worlds" / f"{name}_{digest(flags)}"
    if not folder.exists():
        part = folder.with_name(f"{folder.name}.{os.getpid()}")
        subprocess.run([str(program), "simulate", str(part), *flags, "--quiet"], check=True, stdout=subprocess.DEVNULL)
        part.replace(folder)
    return folder


def all_rows(arguments, absent):
    """Of every world; one that cannot be read loses its rows, which the comparison tells."""
    made, rows = arguments.work / "inputs", []
    folders = {name: (name, rows_of) for name, rows_of in worlds.WORLDS.items()} | worlds.WITHOUT_LABELS
    for name, (folder, rows_of) in folders.items():
        try:
            rows += [] if name in absent else rows_of(name, arguments.data / folder, made / name)
        except (OSError, ValueError, LookupError, RuntimeError) as problem:
            print(f"{name} cannot be read: {problem}", file=sys.stderr)
    for name, (flags, rows_of) in worlds.SIMULATED.items():
        try:
            rows += rows_of(name, simulated(arguments.program, arguments.work, name, flags), made / name)
        except subprocess.CalledProcessError as problem:
            print(f"{name} cannot be simulated: code {problem.returncode}", file=sys.stderr)
    return rows


def line_of(row, runs, inputs):
    try:
        return {**score(row, runs), "inputs": inputs}
    except (ValueError, LookupError, TypeError) as problem:
        lost = dict.fromkeys(COLUMNS, "") | dict(zip(KEYS, row))
        return {**lost, "n": 0, "failed": f"cannot be scored: {problem!r}", "inputs": inputs}


def run_all(runner, rows, arguments):
    extra, extra_map = shlex.split(arguments.extra), shlex.split(arguments.extra_map)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        maps = {runner.map_key(part.map, extra_map): part.map for row in rows for part in row.parts}
        list(pool.map(lambda place: runner.map(place, extra_map), maps.values()))
        runs_of = [pool.submit(lambda row: [runner.localize(p, extra, extra_map) for p in row.parts], r) for r in rows]
        lines, started = [], time.monotonic()
        for row, runs in zip(rows, runs_of):
            lines.append(line_of(row, runs.result(), runner.inputs(row)))
            if arguments.answers:
                with open(arguments.answers, "a") as file:
                    file.writelines(checked_answers(row, runs.result()))
            seconds = time.monotonic() - started
            print(f"{seconds:5.0f} s  {len(lines)} of {len(rows)}  {' '.join(row[:3])}", file=sys.stderr)
    return lines, [runs.result() for runs in runs_of]


def arguments_of():
    root = Path(__file__).resolve().parent.parent
    data = Path(os.environ.get("XVIEW_DATA") or root.parent / "shared/data")
    what, how = __doc__.split("\n\n", 1)
    as_written = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("run regress", description=what, epilog=how, formatter_class=as_written)
    add = parser.add_argument
    add("data", nargs="?", type=Path, metavar="DATA_DIR", default=data, help="else $XVIEW_DATA or ../shared/data")
    add("--program", type=Path, metavar="PATH", default=root / "build/xview", help="default: that of build/")
    add("--baseline", type=Path, metavar="FILE", default=root / "bench/regress_baseline.csv", help="stored table")
    add("--save", type=Path, metavar="FILE", help="store the table as CSV")
    add("--markdown", type=Path, metavar="FILE", help="store the sums over sessions as Markdown")
    add("--answers", type=Path, metavar="FILE", help="append the answers, for xview learn --verdict")
    add("--same", metavar="COMMIT", help="compare answers and maps with those kept of it, byte for byte")
    add("--only", default="", metavar="REGEX", help="rows whose 'world session window' matches")
    add("--jobs", type=int, default=2, metavar="N", help="runs at a time, of one thread each; default 2")
    add("--with", dest="extra", default="", metavar="FLAGS", help="further flags of localize: --with '--method search'")
    add("--with-map", dest="extra_map", default="", metavar="FLAGS", help="further flags of map")
    add("--work", type=Path, metavar="DIR", default=root / "regress", help="where runs are kept; default regress/")
    arguments = parser.parse_args()
    arguments.root = root
    for name in ("program", "work", "data"):
        setattr(arguments, name, getattr(arguments, name).resolve())
    return arguments


def rows_to_check(arguments):
    """The rows that were asked for, and the worlds that are not there."""
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.lock = open(arguments.work / "lock", "w")
    fcntl.flock(arguments.lock, fcntl.LOCK_EX)  # A second check waits for its turn in the same folder.
    folders = {name: name for name in worlds.WORLDS} | {name: of for name, (of, _) in worlds.WITHOUT_LABELS.items()}
    absent = [name for name, folder in folders.items() if not (arguments.data / folder).is_dir()]
    rows = [row for row in all_rows(arguments, absent) if re.search(arguments.only, " ".join(row[:3]))]
    if not rows:
        sys.exit("no row to check")
    return rows, absent


def main():
    arguments = arguments_of()
    rows, absent = rows_to_check(arguments)
    was, runner = answers_to_compare(arguments), Runner(arguments.program, arguments.work)
    lines, runs_of = run_all(runner, rows, arguments)
    baseline = read_table(arguments.baseline) if arguments.baseline.exists() else {}
    notes, said, is_worse = compare(
        lines, baseline, lambda key: re.search(arguments.only, " ".join(key)) and key[0] not in absent)
    table = [heading()] + [cells(line, note) for line, note in zip(lines, notes)]
    if absent:
        said.append(f"{len(absent)} worlds are not in {arguments.data} and were skipped: {', '.join(absent)}")
    print(table_text(table), *said, sep="\n")
    if arguments.save:
        save_table(arguments.save, lines)
    if arguments.markdown:
        arguments.markdown.write_text(table_markdown(by_world(lines)))
    if not arguments.extra and not arguments.extra_map:
        digests = {}
        kept = {" ".join(row[:3]): kept_of(row, runs, runner, digests) for row, runs in zip(rows, runs_of)}
        keep(kept, arguments)
        is_worse |= was is not None and not all_same(kept, was, arguments.same)
    sys.exit(is_worse)


if __name__ == "__main__":
    main()
