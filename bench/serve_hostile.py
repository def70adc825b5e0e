#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Sends hostile requests to a running `xview serve` from many clients at once, and proper ones before, between and after them.

The proper ones must get the same bytes each time (times aside), a hostile one the status that is due to it, with a line of JSON. Memory
must not grow in the second half of the requests by more than 32 MB, the server must end by SIGTERM, and no body may be
left in the folder for temporary files. Prints one line of counts; exit code 1 if anything is another.
"""
import argparse
import collections
import contextlib
import gzip
import json
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST_BODY_MB = 8
MOST_GROWTH_MB = 32
HOST = b"Host: localhost\r\n"


def points(count, rng, *first):
    """A scan as of KITTI: points of a street, after those that are given."""
    near = [(rng.uniform(-40, 40), rng.uniform(-40, 40), rng.uniform(-2, 3)) for _ in range(count)]
    return b"".join(struct.pack("<4f", *p, 0.5) for p in [*first, *near])


def post(body, route="/localize", lines=b"", length=True):
    size = b"Content-Length: %d\r\n" % len(body) if length else b""
    return b"POST %s HTTP/1.1\r\n" % route.encode() + HOST + lines + size + b"\r\n" + body


def chunked(rest):
    return post(rest, lines=b"Transfer-Encoding: chunked\r\n", length=False)


def part(name, content):
    return b'--X\r\nContent-Disposition: form-data; name="a"' + name + b"\r\n\r\n" + content + b"\r\n"


def get(lines, route=b"/health"):
    return b"GET " + route + b" HTTP/1.1\r\n" + lines + b"\r\n"


def kinds(rng, far_points):
    """What is sent, and the statuses that may answer it; 0 = none."""
    nan, inf, huge = float("nan"), float("inf"), 3e38
    much = b"0" * (3 << 20)
    form = b"Content-Type: multipart/form-data; boundary=X\r\n"
    read = (200, 400)  # found, refused by the verdict, or not readable
    far = [
        (post(struct.pack("<4f", 1e12, 1e12, 1e12, 1) * 100), read),
        (post(points(3000, rng, (1e10, 0, 0))), read),
        (post(points(1000, rng, (rng.choice((1e9, 2e9, 1e12, 1e30)), 0, 0))), read),
        (post(struct.pack("<4f", huge, huge, huge, 1) * 1000), read),
        (post(points(1000, rng, (inf, inf, inf))), read),
        (post(rng.randbytes(16000)), read),
    ]
    return [
        *(far if far_points else []),
        (post(struct.pack("<4f", nan, nan, nan, 1) * 1000), (400,)),
        (post(points(1000, rng, (nan, 0, 0), (nan, nan, nan))), read),
        (post(bytes(16 * 1000)), (400,)),
        (post(rng.randbytes(1000), "/localize?name=%1b%5b2J/../x.pcd"), (400,)),
        (post(b"[" * 100000, "/localize?name=a.json"), (400,)),
        (post(b"\x89MCAP0\r\n" + b"\xff" * 1000, "/localize?name=a.mcap"), (400,)),
        (post(b"x", "/track/robot?pose=1+nan+2+3+0+0+0+1"), (400,)),
        (rng.randbytes(3000) + b"\r\n\r\n", (400, 414)),
        (bytes(100000), (414,)),
        (get(HOST, b"/" + b"a" * 100000), (414,)),
        (get(HOST + b"A: " + b"b" * 20000 + b"\r\n"), (431,)),
        (get(HOST + b"".join(b"A%d: b\r\n" % i for i in range(20000))), (431,)),
        (get(b""), (421,)),
        (get(b"Host: evil.example\r\nOrigin: http://evil.example\r\n"), (421,)),
        (get(HOST + b"Origin: http://evil.example\r\n"), (403,)),
        (b"PUT /localize HTTP/1.1\r\n" + HOST + b"\r\n", (405,)),
        (get(HOST, b"/../../etc/passwd"), (404,)),
        (get(HOST + b"Range: bytes=" + b"0-," * 2500 + b"0-\r\n", b"/openapi.json"), (200,)),
        (post(b"x", lines=b"Content-Length: 7\r\n"), (400,)),
        (post(b"x", lines=b"Content-Length: -1\r\n", length=False), (400,)),
        (post(b"x", lines=b"Content-Length: 99999999999\r\n", length=False), (413,)),
        (post(b"x", lines=b"Content-Encoding: zstd\r\n"), (415,)),
        (post(b"x", lines=b"Transfer-Encoding: gzip\r\n", length=False), (501,)),
        (chunked(much), (413,)),
        (chunked(b"1;" + much), (413,)),
        (chunked(b"ffffffffffffffff\r\nabc\r\n0\r\n\r\n"), (400,)),
        (chunked(b"1\r\nx\r\n" * 2000000), (413,)),
        (post(gzip.compress(bytes(4 * MOST_BODY_MB << 20)), lines=b"Content-Encoding: gzip\r\n"), (413,)),
        (post(part(b"", b"b") + b"--X--\r\n", lines=form), (400,)),
        (post(b"--X" + much, lines=form), (400, 413)),
        (post(part(b'; filename="a.pcd"', b"# x") + b"--X--\r\n", lines=form), (400,)),
    ]


class Clients:
    """Of one server. Counts what they got."""

    def __init__(self, port, pid, query, requests, seed):
        self.port, self.pid, self.query, self.requests, self.random = port, pid, query, requests, random.Random(seed)
        self.lock = threading.Lock()
        self.statuses, self.wrong = collections.Counter(), []
        self.equal = self.other = 0
        self.right = None

    def answer(self, data, gone=False):
        """All that comes back, also if the server takes no more; with `gone` the client does not wait for it."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=120) as client:
            with contextlib.suppress(ConnectionError):
                client.sendall(data)
            parts = [b""]
            with contextlib.suppress(ConnectionError):
                while not gone and (came := client.recv(1 << 16)):
                    parts.append(came)
            return b"".join(parts)

    def ask(self):
        """A proper query, which is asked again if the server is busy."""
        for _ in range(10):
            head, _, body = self.answer(post(self.query, "/localize?name=query.ply")).partition(b"\r\n\r\n")
            if b" 503 " not in head.partition(b"\r\n")[0]:
                break
        try:
            untimed = json.loads(body)
            untimed.pop("timing_ms")
        except (ValueError, KeyError):
            untimed = None
        with self.lock:
            self.right = self.right or untimed
            is_equal = untimed is not None and untimed == self.right
            self.equal += is_equal
            self.other += not is_equal

    def slow(self):
        """A byte now and then of a body, or of a head, and gone."""
        begin = self.random.choice((post(bytes(1000))[:-1000], b"GET /hea", b"", chunked(b"1")))
        with socket.create_connection(("127.0.0.1", self.port), timeout=120) as client, contextlib.suppress(ConnectionError):
            client.sendall(begin)
            for _ in range(4):
                time.sleep(0.2)
                client.sendall(b"0")

    def attack(self, number):
        kind = number % (len(self.requests) + 3)
        if kind >= len(self.requests):
            if kind % 3 == 0:
                self.answer(post(self.query)[: self.random.randrange(len(self.query))], gone=True)
            else:
                self.slow()
            return self.count("gone")
        data, due = self.requests[kind]
        head, _, body = self.answer(data).partition(b"\r\n\r\n")
        status = int(head.split(b" ")[1]) if head.startswith(b"HTTP/1.1 ") else 0
        with contextlib.suppress(ValueError):
            json.loads(body)
            if status in due:
                return self.count(status)
        with self.lock:
            self.wrong.append(f"{status} {body[:100]} for {data[:80]}")
        return self.count(status)

    def count(self, status):
        with self.lock:
            self.statuses[status] += 1

    def memory_mb(self):
        lines = Path(f"/proc/{self.pid}/status").read_text().splitlines()
        return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))

    def attack_all(self, numbers, clients):
        """From as many threads; proper queries meanwhile."""
        left, is_over = iter(numbers), threading.Event()

        def attacker():
            while True:
                with self.lock:
                    number = next(left, None)
                if number is None:
                    return
                self.attack(number)

        def asker():
            while not is_over.is_set():
                self.ask()

        attackers = [threading.Thread(target=attacker) for _ in range(clients)]
        proper = threading.Thread(target=asker)
        for thread in [*attackers, proper]:
            thread.start()
        for thread in attackers:
            thread.join()
        is_over.set()
        proper.join()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", nargs="?", type=int, default=500, help="hostile requests (default 500)")
    parser.add_argument("--clients", default=16, type=int)
    parser.add_argument("--program", default=ROOT / "build/xview", type=Path)
    parser.add_argument("--far-points", default=True, action=argparse.BooleanOptionalAction, help="points at 1e9 m and more, too")
    parser.add_argument("--seed", default=1, type=int)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)

        def run(*words):
            subprocess.run([arguments.program, *map(str, words), "-q"], check=True, stdout=subprocess.DEVNULL)

        run("simulate", folder / "town", "--seed", 5, "--route_length_m", 84, "--width", 160, "--height", 120)
        run("map", folder / "town/forward", folder / "town.xvm")
        run("lift", folder / "town/rear", "--frames", "0:20", folder / "query.ply")
        (folder / "tmp").mkdir()
        errors = (folder / "errors").open("w")
        server = subprocess.Popen([arguments.program, "serve", "-q", folder / "town.xvm", "--port", "0", "--patience", "20", "--timeout", "20",
                                   "--max-body", str(MOST_BODY_MB)], stdout=subprocess.PIPE, stderr=errors, text=True,
                                  env={**os.environ, "TMPDIR": str(folder / "tmp")})
        port = int(server.stdout.readline().rpartition(":")[2])
        clients = Clients(port, server.pid, (folder / "query.ply").read_bytes(),
                          kinds(random.Random(arguments.seed), arguments.far_points), arguments.seed)
        try:
            clients.ask()
            half = arguments.count // 2
            clients.attack_all(range(half), arguments.clients)
            before_mb = clients.memory_mb()
            clients.attack_all(range(half, arguments.count), arguments.clients)
            after_mb = clients.memory_mb()
            clients.ask()
        finally:
            server.send_signal(signal.SIGTERM)
            try:
                code = server.wait(60)
            except subprocess.TimeoutExpired:
                server.kill()
                code = server.wait()
        left = list((folder / "tmp").iterdir())
        lines = (folder / "errors").read_text().count("\n")
    counts = ", ".join(f"{number} x {status}" for status, number in sorted(clients.statuses.items(), key=str))
    print(f"{arguments.count} hostile requests of {arguments.clients} clients: {counts}; {len(clients.wrong)} not as due; "
          f"{clients.equal} proper ones answered with the same bytes, {clients.other} with others; memory {before_mb:.0f} -> {after_mb:.0f} MB; "
          f"{lines} lines on stderr; {len(left)} folders left; exit code {code}")
    for wrong in clients.wrong[:5]:
        print(wrong, file=sys.stderr)
    sys.exit(bool(clients.wrong or clients.other or left or code != 143 or after_mb > before_mb + MOST_GROWTH_MB))


if __name__ == "__main__":
    main()
