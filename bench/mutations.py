#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Damages files of every format at random, gives them to `xview` and prints as a table what it does with them and what that costs.

Per format COUNT files: some bytes changed, a number set to an extreme, a part doubled, removed or cut off. A file may be read, or be
refused with exit code 1 or 2 and one line; it must not crash, take 2 s of CPU or 400 MB more than the honest file, or leave an output
after a refusal. Exit code 1 if one does. Honest files are made by the program; those of other programs' formats are in --seeds, where
`build-fuzz/test/fuzz/make_fuzz_seeds SEEDS` puts them (SEEDS has a folder per target), and in DATA/las_readers. E57 files get right sums
after they were damaged, or nothing behind them would be read. With --runner a hundred commands at a time are run in one process, which
is ten times as fast; what one of them leaves behind would then show as well.
"""
import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table

ROOT = Path(__file__).resolve().parent.parent
MOST_CPU_S, MOST_MB = 2, 400
EXTREMES = [bytes(n) for n in (1, 2, 4, 8)] + [b"\xff" * n for n in (1, 2, 4, 8)] + [b"\x7f" + b"\xff" * 3, b"\xff\xff\xff\x7f", b"-1", b"1e308", b"nan"]


def damaged(data, chance):
    """Other bytes."""
    data = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 5))):
        at = chance.randrange(max(1, min(len(data), chance.choice((64, 512, 1 << 30)))))
        kind = chance.randrange(5)
        if kind == 0:
            data[at:at + 1] = bytes([chance.randrange(256)])
        elif kind == 1:
            value = chance.choice(EXTREMES)
            data[at:at + len(value)] = value
        elif kind == 2:
            data[at:at] = data[at:at + chance.choice((1, 4, 100, 5000))]
        elif kind == 3:
            del data[at:at + chance.choice((1, 4, 100, 5000))]
        elif len(data) > 1:
            del data[chance.randrange(len(data)):]
    return bytes(data)


def with_sums(content):
    """An E57 file of these bytes: pages of 1020 with a big-endian CRC-32C each; the size of the file in the header is right."""
    pages = -(-len(content) // 1020)
    content = bytearray(content.ljust(pages * 1020, b"\0"))
    content[16:24] = (pages * 1024).to_bytes(8, "little")
    file = bytearray()
    for i in range(pages):
        page = content[i * 1020:(i + 1) * 1020]
        total = 0xffffffff
        for byte in page:
            total ^= byte
            for _ in range(8):
                total = total >> 1 ^ 0x82f63b78 * (total & 1)
        file += page + (total ^ 0xffffffff).to_bytes(4, "big")
    return bytes(file)


class ManyCommands:
    """Runs commands in processes of bench/many_commands.cpp."""
    COMMANDS = 100  # of a process; the next one begins with fresh memory

    def __init__(self, path):
        self.path, self.process, self.left = path, None, 0

    def run(self, said, arguments):
        """Exit status, CPU seconds and peak memory so far [kB]."""
        if self.left == 0:
            self.end()
        if not self.process:
            self.process = subprocess.Popen([self.path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
            self.left = self.COMMANDS
        self.left -= 1
        self.process.stdin.write("\t".join([str(said), *arguments]) + "\n")
        answer = self.process.stdout.readline().split()
        if answer:
            return int(answer[0]), float(answer[1]), float(answer[2])
        return min(self.end(), 0) or 126, 0.0, 0.0  # it must not end, by whatever code

    def end(self):
        """Exit status of the process; the next command begins another one."""
        code = 0
        if self.process:
            self.process.communicate()
            code = self.process.returncode
        self.process = None
        return code


def spawned(program, said, arguments):
    """The same by a process of its own."""
    with open(said, "wb") as file, open(os.devnull, "wb") as nothing:
        pid = os.posix_spawn(program, [str(program), *arguments], os.environ,
                             file_actions=[(os.POSIX_SPAWN_DUP2, file.fileno(), 2), (os.POSIX_SPAWN_DUP2, nothing.fileno(), 1)])
        _, status, usage = os.wait4(pid, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, usage.ru_maxrss


class Checker:
    def __init__(self, program, runner, scratch, seed):
        self.program, self.scratch, self.chance = program, scratch, random.Random(seed)
        self.runner = runner and ManyCommands(runner)

    def run(self, arguments):
        """Exit status, lines of stderr, CPU seconds and peak memory of the program."""
        said, arguments = self.scratch / "said", [*map(str, arguments), "--threads", "1", "-q"]
        code, cpu_s, rss_kb = self.runner.run(said, arguments) if self.runner else spawned(self.program, said, arguments)
        return code, said.read_text(errors="replace").splitlines(), cpu_s, rss_kb / 1024

    def made(self, *arguments):
        if self.run(arguments)[0] != 0:
            sys.exit(f"xview {' '.join(map(str, arguments))} failed: {(self.scratch / 'said').read_text()}")

    def formats(self, seeds, data):
        """Name, file that is damaged, and the command that reads it."""
        town, out = self.scratch / "town", self.scratch / "out.xvm"
        self.made("simulate", town, "--seed", 5, "--route_length_m", 84, "--width", 160, "--height", 120, "--sessions.lidar", "--sessions.aerial=false")
        copy = self.scratch / "rear"
        shutil.copytree(town / "rear", copy)
        files = self.scratch / "files"
        files.mkdir()
        for name in ("cloud.pcd", "cloud.ply"):
            self.made("lift", town / "lidar_reverse", files / name, "--frames", "0:2")
        self.made("graph", town / "rear", files / "graph.ply", "--frames", "0:8")
        self.made("map", town / "forward", files / "town.xvm", "--frames", "0:12")
        answers = self.scratch / "answers.jsonl"
        self.run(("localize", town / "rear", files / "town.xvm", "--window", 8, "-o", answers))
        few, read = (copy, "--frames", "0:2"), lambda path: ("map", path, out)
        found = [("PCD", files / "cloud.pcd", read), ("PLY", files / "cloud.ply", read), ("PLY graph", files / "graph.ply", read),
                 ("map (.xvm)", files / "town.xvm", lambda path: ("localize", town / "rear", path, "--frames", "0:4")),
                 ("answers", answers, lambda path: ("evaluate", path, town / "rear/groundtruth.txt"))]
        for name, file in (("depth image", min((copy / "depth").iterdir())), ("label image", min((copy / "label").iterdir())),
                           ("poses", copy / "poses.txt"), ("classes.yaml", copy / "classes.yaml"), ("camera.yaml", copy / "camera.yaml")):
            found.append((name, file, lambda path: ("map", *few, out)))
        for name, folder, pattern in (("MCAP", "mcap", "o.mcap"), ("ROS 1 bag", "rosbag", "_seed.bag"), ("rosbag2 .db3", "db3", "seed.db3")):
            file = seeds / folder / pattern if seeds else None
            if file and file.exists():
                found.append((name, file, lambda path: ("info", path)))
        for file in [seeds / "e57/two.e57"] if seeds else []:
            found.append(("E57", file, read))
        found += [("LAS", file, read) for file in (data / "las_readers/simple.las",) if file.exists()]
        return out, found

    def row(self, name, honest, command, out, count):
        inside = honest.is_relative_to(self.scratch)
        target = honest if inside else self.scratch / honest.name
        data = honest.read_bytes()
        finished = with_sums if honest.suffix == ".e57" else bytes
        target.write_bytes(finished(data))
        if self.runner:
            self.runner.end()  # memory of this format alone
        code, lines, honest_s, honest_mb = self.run(command(target))
        if code not in (0, 3):
            sys.exit(f"{name}: the honest file is not read: {lines}")
        out.unlink(missing_ok=True)
        read, bad, most_s, most_mb = 0, [], 0.0, 0.0
        for number in range(count):
            other = damaged(data, self.chance)
            target.write_bytes(finished(other))
            code, lines, cpu_s, mb = self.run(command(target))
            read += code in (0, 3)
            most_s, most_mb = max(most_s, cpu_s - honest_s), max(most_mb, mb - honest_mb)
            if (code not in (0, 1, 2, 3) or code in (1, 2) and len(lines) != 1 or cpu_s > honest_s + MOST_CPU_S or mb > honest_mb + MOST_MB
                    or code in (1, 2) and out.exists()):
                bad.append((number, code, lines[:2], round(cpu_s, 2), round(mb)))
                shutil.copy(target, Path.cwd() / f"mutation_{name.replace(' ', '_')}_{number}{target.suffix}")
            out.unlink(missing_ok=True)
        target.write_bytes(data)
        print(f"{name}: {count} files, {read} read, {len(bad)} bad {bad[:3]}", file=sys.stderr, flush=True)
        return [name, count, read, count - read, f"{max(0, most_s):.2f}", f"{max(0, most_mb):.0f}", len(bad)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", nargs="?", type=int, default=100, help="files of each format (default 100)")
    parser.add_argument("--program", default=ROOT / "build/xview", type=Path)
    parser.add_argument("--runner", type=Path, metavar="PROGRAM", help="build/bench/many_commands")
    parser.add_argument("--only", nargs="+", help="formats by their names in the table")
    parser.add_argument("--seeds", type=Path)
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("XVIEW_DATA") or ROOT.parent / "shared/data"))
    parser.add_argument("--seed", default=1, type=int)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        checker = Checker(arguments.program.resolve(), arguments.runner, Path(scratch), arguments.seed)
        out, formats = checker.formats(arguments.seeds, arguments.data)
        rows = [checker.row(*of_format, out, arguments.count) for of_format in formats if not arguments.only or of_format[0] in arguments.only]
    rows.append(["all", *(sum(row[i] for row in rows) for i in (1, 2, 3)), max((row[4] for row in rows), key=float), max((row[5] for row in rows), key=float),
                 sum(row[6] for row in rows)])
    print(table([["format", "files", "read all the same", "refused", "CPU beyond the honest file, s, at most", "memory beyond it, MB, at most", "anything else"], *rows]))
    sys.exit(rows[-1][6] > 0)


if __name__ == "__main__":
    main()
