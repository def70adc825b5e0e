#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Gives `xview` files that were made to do harm, one command each, and prints what came of them as a table.

Journals and write-ahead logs planted beside maps, databases that define views and computed columns, bags and E57 files whose few bytes
ask for much. Each command must end with one line and exit code 1 or 2, or read the file right, within 10 s of computing and 500 MB, and
leave every file in the folder as it was, with none added or removed. Exit code 1 if anything is another. What needs the programs `zstd`
or `lz4` is passed over without them.
"""
import argparse
import bz2
import hashlib
import os
import resource
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

sys.dont_write_bytecode = True
from paper_page import table

ROOT = Path(__file__).resolve().parent.parent
MOST_S, MOST_MB, PATIENCE_S = 10, 500, 120
MIB = 1 << 20
CLOUD, IMAGE, CAMERA = ("sensor_msgs/msg/" + name for name in ("PointCloud2", "Image", "CameraInfo"))
ODOMETRY = "nav_msgs/msg/Odometry"


# ---- messages, as CDR has them

class Message:
    def __init__(self, stamp_s=10.0):
        self.content = bytearray()
        self.put("I", int(stamp_s)).put("I", int(stamp_s % 1 * 1e9)).text("lidar")

    def put(self, kind, *values):
        for value in values:
            while len(self.content) % struct.calcsize(kind):
                self.content += b"\0"
            self.content += struct.pack("<" + kind, value)
        return self

    def text(self, words):
        self.put("I", len(words) + 1).content += words.encode() + b"\0"
        return self

    def raw(self, data):
        self.content += data
        return self

    def done(self):
        return b"\0\1\0\0" + bytes(self.content)


def cloud(points, data=None, stamp_s=10.0):
    """A PointCloud2; without its data, where zeros of that number are to follow."""
    message = Message(stamp_s).put("I", 1, points, 3)
    for axis, offset in (("x", 0), ("y", 4), ("z", 8)):
        message.text(axis).put("I", offset).put("B", 7).put("I", 1)
    message.put("B", 0).put("I", 12, 12 * points, 12 * points)
    return message.done() if data is None else message.raw(data).put("B", 1).done()


def odometry(stamp_s):
    return Message(stamp_s).text("lidar").put("d", stamp_s, 0, 0, 0, 0, 0, 1, *[0.0] * 78).done()


def image():
    return Message().put("I", 4, 4).text("16UC1").put("B", 0).put("I", 8, 32).raw(b"\1\0" * 16).done()


def camera():
    k, p = (4.0, 0, 2, 0, 4, 2, 0, 0, 1), (4.0, 0, 2, 0, 0, 4, 2, 0, 0, 0, 1, 0)
    return Message().put("I", 4, 4).text("plumb_bob").put("I", 0).put("d", *k, *k, *p).done()


def some_points():
    return b"".join(struct.pack("<3f", i % 50 - 25, i // 50 - 25, i % 7) for i in range(2500))


# ---- files of messages

def words(text):
    data = text.encode() if isinstance(text, str) else text
    return struct.pack("<I", len(data)) + data


def record(kind, content):
    return struct.pack("<BQ", kind, len(content)) + content


MAGIC = b"\x89MCAP0\r\n"


def mcap(*records, types=(CLOUD, ODOMETRY), channels=()):
    """`channels`: the number of the type of each, from 1; both are numbered from 1."""
    out = [MAGIC, record(1, words("ros2") + words("x"))]
    out += [record(3, struct.pack("<H", i + 1) + words(name) + words("ros2msg") + words("")) for i, name in enumerate(types)]
    out += [record(4, struct.pack("<HH", i + 1, of) + words(f"/t{i + 1}") + words("cdr") + words("")) for i, of in enumerate(channels)]
    return b"".join([*out, *records, record(15, bytes(4)), record(2, bytes(20)), MAGIC])


def said(channel, content, stamp_s=10.0, size=None):
    """A message; `size` if more is to follow than its content."""
    ns = int(stamp_s * 1e9)
    head = struct.pack("<HIQQ", channel, 0, ns, ns)
    return struct.pack("<BQ", 5, len(head) + (size or len(content))) + head + content


def chunk(how, packed, size):
    return record(6, struct.pack("<QQQI", 0, 0, size, 0) + words(how) + struct.pack("<Q", len(packed)) + packed)


def index(channel, places):
    return record(7, struct.pack("<HI", channel, 16 * len(places)) + b"".join(struct.pack("<QQ", *place) for place in places))


def ros1(data, **fields):
    return words(b"".join(words(name.encode() + b"=" + value) for name, value in fields.items())) + words(data)


def zeros_packed(tool, zeros, begin=b""):
    """Bytes with so many zeros behind them, packed, without holding them in memory."""
    pieces = (begin, *[bytes(MIB)] * (zeros // MIB), bytes(zeros % MIB))
    if tool == "bz2":
        packer = bz2.BZ2Compressor()
        return b"".join(packer.compress(piece) for piece in pieces) + packer.flush()
    # A regular file, because only then the size of the content is in the frame.
    with tempfile.NamedTemporaryFile() as file:
        for piece in pieces:
            file.write(piece)
        file.flush()
        return subprocess.run([tool, "-q", "-c", "-3", file.name], stdout=subprocess.PIPE, check=True).stdout


def database(path, rows, sql=(), topics=((1, "/points", CLOUD), (2, "/odom", ODOMETRY))):
    made = sqlite3.connect(path)
    made.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)")
    made.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
    made.executemany("INSERT INTO topics VALUES(?, ?, ?, 'cdr')", topics)
    made.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", rows)
    for statement in sql:
        made.execute(statement)
    made.commit()
    return made


# ---- what is tried; each function fills a folder and returns the file to open

def drive():
    return [(1, 10_000_000_000, cloud(2500, some_points()))] + [(2, int(1e9 * (9 + i / 10)), odometry(9 + i / 10)) for i in range(20)]


ENDLESS = "AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x AS id, 1 AS topic_id, x AS timestamp, " \
          "'n' || x AS name, 'x' AS type, 'cdr' AS serialization_format FROM c"


def schema_row(kind, name, sql):
    return ("PRAGMA writable_schema = ON", "INSERT INTO sqlite_master(rowid, type, name, tbl_name, rootpage, sql) VALUES(-5, "
            f"'{kind}', '{name}', '{name}', 0, '{sql.replace(chr(39), chr(39) * 2)}')")


def defines(*sql):
    def make(folder):
        database(folder / "a.db3", drive(), sql).close()
        return folder / "a.db3"
    return make


def computed_name(folder):
    made = sqlite3.connect(folder / "a.db3")
    made.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT AS (zeroblob(900000000)), type TEXT, serialization_format TEXT)")
    made.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
    made.executemany("INSERT INTO topics(id, type, serialization_format) VALUES(?, 'x', 'cdr')", [(i,) for i in range(20)])
    made.commit()
    made.close()
    return folder / "a.db3"


def killed_recorder(folder):
    """All but the first page is in the write-ahead log."""
    with tempfile.TemporaryDirectory() as other:
        made = sqlite3.connect(Path(other) / "a.db3")
        made.execute("PRAGMA journal_mode = WAL")
        made.close()
        made = database(Path(other) / "a.db3", drive())
        for ending in ("", "-wal"):
            shutil.copy(f"{other}/a.db3{ending}", f"{folder}/a.db3{ending}")
        made.close()
    return folder / "a.db3"


def packed_rows(count):
    def make(folder):
        big = zeros_packed("zstd", 12 * 80 * MIB + 1, cloud(80 * MIB))
        database(folder / "a.db3", [(1, 10_000_000_000 + i, big) for i in range(count)]).close()
        return folder / "a.db3"
    return make


def file_of(name, content):
    def make(folder):
        (folder / name).write_bytes(content())
        return folder / name
    return make


def bombs(tool, count, claimed=None):
    size = (1 << 30) - 1
    one = lambda: chunk(tool, zeros_packed(tool, size), size if claimed is None else claimed)
    return file_of("a.mcap", lambda: mcap(one() * count))


def bz2_bomb():
    packed = zeros_packed("bz2", 1 << 30)
    return b"#ROSBAG V2.0\n" + ros1(packed, op=b"\5", compression=b"bz2", size=struct.pack("<I", 1 << 30))


def many_channels(points, channels):
    """All of them are said to have one message, of so many points."""
    head = said(1, cloud(points), size=len(cloud(points)) + 12 * points + 1)
    size = len(head) + 12 * points + 1
    packed = chunk("zstd", zeros_packed("zstd", size - len(head), head), size)
    return mcap(packed, *[index(i + 1, [(10, 0)]) for i in range(channels)], channels=[1] * channels)


def one_message_many_times():
    content = said(1, cloud(2500, some_points()))
    places = [(10_000_000_000 + 1000 * i, 0) for i in range(100_000)]
    return mcap(chunk("", content, len(content)), index(1, places), *[said(2, odometry(9 + i / 10), 9 + i / 10) for i in range(30)],
                channels=(1, 2))


def large_chunks():
    out = []
    for i in range(4):
        begin = said(1, cloud(2500, some_points(), 10 + i / 10), 10 + i / 10)
        packed = zeros_packed("zstd", 900 * MIB, begin)
        out += [chunk("zstd", packed, len(begin) + 900 * MIB), index(1, [(10_000_000_000 + 100_000_000 * i, 0)])]
    return mcap(*out, *[said(2, odometry(9 + i / 10), 9 + i / 10) for i in range(30)], channels=(1, 2))


def many_images():
    count = 16000
    return mcap(*[said(i + 1, image()) for i in range(count)], *[said(count + i + 1, camera()) for i in range(count)],
                types=(IMAGE, CAMERA), channels=[1] * count + [2] * count)


def many_connections():
    about = b"".join(words(b"%s" % field) for field in (b"topic=/t", b"type=std_msgs/String", b"md5sum=0", b"message_definition="))
    return b"#ROSBAG V2.0\n" + b"".join(
        ros1(about, op=b"\7", conn=struct.pack("<I", i), topic=b"/t%d" % i) for i in range(1_000_000))


def e57(inner, before=""):
    """A file whose XML has this in its root; its scan is not looked at before that."""
    sums = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
        sums.append(byte)
    xml = f'<?xml version="1.0" encoding="UTF-8"?>{before}<e57Root type="Structure">{inner}<data3D type="Vector"/></e57Root>'.encode()
    pages = -(-(48 + len(xml)) // 1020)
    content = b"ASTM-E57" + struct.pack("<IIQQQQ", 1, 0, 1024 * pages, 48, len(xml), 1024) + xml
    out = []
    for at in range(0, 1020 * pages, 1020):
        page = content[at:at + 1020].ljust(1020, b"\0")
        state = 0xFFFFFFFF
        for byte in page:
            state = sums[(state ^ byte) & 0xFF] ^ state >> 8
        out.append(page + struct.pack(">I", state ^ 0xFFFFFFFF))
    return b"".join(out)


def journal(pages, name=b"", page_bytes=4096, records=0):
    head = bytes.fromhex("d9d505f920a163d7") + struct.pack(">5I", records, 7, pages, 512, page_bytes)
    end = struct.pack(">I", 262145) + name + struct.pack(">2I", len(name), sum(name)) + head[:8] if name else b""
    return head.ljust(512, b"\0") + end


def planted(town, ending, content):
    """`content(folder, pages of the map)` beside a map, and a file that a journal may name."""
    def make(folder):
        shutil.copy(town, folder / "town.xvm")
        (folder / "precious.txt").write_text("precious\n")
        (folder / f"town.xvm{ending}").write_bytes(content(folder, town.stat().st_size // 4096))
        return folder / "town.xvm"
    return make


def planted_log(folder, _pages):
    with tempfile.TemporaryDirectory() as other:
        shutil.copy(folder / "town.xvm", f"{other}/w.xvm")
        made = sqlite3.connect(f"{other}/w.xvm")
        made.execute("PRAGMA journal_mode = WAL")
        made.execute("UPDATE sources SET path = 'from the log'")
        made.commit()
        log = Path(f"{other}/w.xvm-wal").read_bytes()
        made.close()
    return log


def many_changes(town):
    def make(folder):
        shutil.copy(town, folder / "town.xvm")
        made = sqlite3.connect(folder / "town.xvm")
        made.execute("CREATE TABLE undo_steps(step INTEGER PRIMARY KEY, note TEXT)")
        made.execute("CREATE TABLE undo_visits(step INTEGER, sigma_m REAL, data BLOB)")
        made.executemany("INSERT INTO undo_steps VALUES(?, 'x')", [(i,) for i in range(1_000_000)])
        made.commit()
        made.close()
        return folder / "town.xvm"
    return make


def long_name(folder):
    (folder / "depth.txt").write_text("1.0 " + "a" * 100_000 + ".png\n")
    (folder / "groundtruth.txt").write_text("1.0 0 0 0 0 0 0 1\n")
    (folder / "camera.yaml").write_text("width: 8\nheight: 6\nfx: 8\nfy: 8\ncx: 3.5\ncy: 2.5\n")
    return folder


def trials(town):
    """Name, what makes it, commands, whether it must be refused."""
    of_bag, of_map = ("info", "localize"), ("info", "localize", "view", "append", "undo", "fuse", "prune")
    key = lambda folder, pages: journal(pages, os.fsencode(folder / "precious.txt"))
    yield from (
        ("journal that names a file", planted(town, "-journal", key), of_map, True),
        ("journal of one page", planted(town, "-journal", lambda f, n: journal(1)), of_map, True),
        ("journal of one page, with a record", planted(town, "-journal", lambda f, n: journal(1, records=1) + bytes(4104)), of_map, True),
        ("text as a journal", planted(town, "-journal", lambda f, n: b"precious\n"), of_map, True),
        ("write-ahead log of another map", planted(town, "-wal", planted_log), of_map, True),
        ("1,000,000 changes on record", many_changes(town), ("info", "undo", "prune"), False),
        ("db3: view MESSAGES", defines(*schema_row("view", "MESSAGES", "CREATE VIEW MESSAGES " + ENDLESS)), of_bag, True),
        ("db3: view TOPICS as a table", defines(*schema_row("table", "TOPICS", "CREATE VIEW TOPICS " + ENDLESS)), of_bag, True),
        ("db3: virtual table", defines(*schema_row("table", "MESSAGES", "CREATE VIRTUAL TABLE MESSAGES USING fts5(a)")), of_bag, True),
        ("db3: trigger", defines("CREATE TRIGGER t AFTER INSERT ON topics BEGIN SELECT 1; END"), of_bag, True),
        ("db3: computed column of 900 MB", computed_name, of_bag, True),
        ("db3: killed recorder", killed_recorder, of_bag, False),
        ("MCAP: index names one message 100,000 times", file_of("a.mcap", one_message_many_times), ("info", "map"), True),
        ("MCAP: 16,000 images and cameras", file_of("a.mcap", many_images), of_bag, False),
        ("bag: 1,000,000 connections", file_of("a.bag", many_connections), of_bag, True),
        ("bag: 1 GiB of bz2", file_of("a.bag", bz2_bomb), of_bag, True),
        ("E57: 1,000,000 attributes", file_of("a.e57", lambda: e57("<a " + " ".join(f'b{i}="1"' for i in range(1_000_000)) + "/>")), of_bag,
         True),
        ("E57: entities of entities", file_of("a.e57", lambda: e57("<guid>&b;</guid>", '<!DOCTYPE a [<!ENTITY b "bbbb">]>')), of_bag, True),
        ("TUM: name of 100,000 letters", long_name, of_bag, True),
    )
    if shutil.which("zstd"):
        yield from (
            ("db3: 960 MB in one row", packed_rows(1), of_bag, True),
            ("db3: 960 MB in 4 rows", packed_rows(4), of_bag, True),
            ("MCAP: 1 GiB of zstd", bombs("zstd", 1), of_bag, True),
            ("MCAP: 1 GiB of zstd that says 100 bytes", bombs("zstd", 1, 100), of_bag, True),
            ("MCAP: 20 times 1 GiB of zstd", bombs("zstd", 20), of_bag, True),
            ("MCAP: 200 channels, one message of 96 MB", file_of("a.mcap", lambda: many_channels(8 * MIB, 200)), of_bag, True),
            ("MCAP: 200 channels, one message of 30 MB", file_of("a.mcap", lambda: many_channels(5 * MIB // 2, 200)), of_bag, True),
            ("MCAP: one message of 30 MB", file_of("a.mcap", lambda: many_channels(5 * MIB // 2, 1)), of_bag, False),
            ("MCAP: 4 chunks of 900 MB", file_of("a.mcap", large_chunks), ("info", "map"), True),
        )
    if shutil.which("lz4"):
        yield ("MCAP: 1 GiB of lz4", bombs("lz4", 1), of_bag, True)


# ---- how it is tried

class Trier:
    def __init__(self, program, scratch):
        self.program, self.scratch = program, scratch
        self.world = scratch / "town"
        self.town = scratch / "town.xvm"

    def prepare(self):
        made = self.run("simulate", self.world, "--seed", 5, "--route_length_m", 60, "--width", 160, "--height", 120)
        made = made[0] or self.run("map", self.world / "forward", self.town)[0]
        if made:
            sys.exit("the town for the trials cannot be made")

    def arguments(self, command, path):
        return {"info": ("info", path), "view": ("view", path, "-o", self.scratch / "view.png"),
                "localize": ("localize", self.world / "rear", path) if path.suffix == ".xvm" else
                            ("localize", path, self.town, "--frames", "0:1"),
                "append": ("map", "--append", self.world / "rear", path), "undo": ("map", "--undo", path),
                "fuse": ("fuse", self.world / "rear", path), "prune": ("prune", path),
                "map": ("map", path, self.scratch / "made.xvm")}[command]

    def run(self, *arguments):
        """Exit code, lines on stderr, seconds of computing, MB."""
        threads = () if arguments[0] == "simulate" else ("--threads", "1")
        process = subprocess.Popen([self.program, *map(str, arguments), "-q", *threads],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30)))
        timer = threading.Timer(PATIENCE_S, process.kill)
        timer.start()
        lines = process.stderr.read().decode(errors="replace").splitlines()
        _, status, used = os.wait4(process.pid, 0)
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, lines, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024

    @staticmethod
    def state(folder):
        return {path.name: hashlib.sha256(path.read_bytes()).digest() for path in folder.iterdir() if path.is_file()}

    def row(self, name, make, commands, must_refuse):
        folder = self.scratch / "trial"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        path = make(folder)
        before, size = self.state(folder), sum(file.stat().st_size for file in folder.iterdir())
        faults, codes, most_s, most_mb, said_last = [], [], 0, 0, ""
        for command in commands:
            code, lines, cpu_s, mb = self.run(*self.arguments(command, path))
            codes.append(code)
            most_s, most_mb = max(most_s, cpu_s), max(most_mb, mb)
            said_last = lines[-1] if lines else said_last
            changes = command in ("append", "undo", "fuse", "prune") and code == 0
            for is_wrong, what in ((code not in ((1, 2) if must_refuse else (0, 1, 2, 3)), f"exit code {code}"),
                                   (code in (1, 2) and len(lines) != 1, f"{len(lines)} lines"),
                                   (any(len(line) > 3000 for line in lines), "a long line"),
                                   (cpu_s > MOST_S, f"{cpu_s:.0f} s"), (mb > MOST_MB, f"{mb:.0f} MB"),
                                   (not changes and self.state(folder) != before, "files changed")):
                if is_wrong:
                    faults.append(f"{command}: {what}")
        print(f"{name}: {said_last[:200]}", file=sys.stderr)
        return [name, f"{size:,}", " ".join(map(str, codes)), f"{most_s:.2f}", f"{most_mb:.0f}", "; ".join(faults) or "-"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=ROOT / "build/xview")
    parser.add_argument("--only", default="", help="trials whose names have this in them")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        trier = Trier(given.program, Path(scratch))
        trier.prepare()
        rows = [trier.row(*trial) for trial in trials(trier.town) if given.only in trial[0]]
    print(table([["file", "bytes", "exit codes", "CPU, s, at most", "memory, MB, at most", "anything else"], *rows]))
    sys.exit(any(row[-1] != "-" for row in rows))


if __name__ == "__main__":
    main()
