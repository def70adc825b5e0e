#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The lines of each room against its budget, the public headers, and all lines together.

    bench/size.py

A room may have 5 % more lines than its budget. Rooms that were above it when budgets were set have a limit of their
own, which they may not pass either. Exit code 1 if a room is above its limit.
"""
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# room: folders and files, budget in lines, limit of what is above it
ROOMS = {
    "include": (["include/xview"], 2600, None),
    "base": (["src/base"], 3200, 3365),
    "process": (["src/process"], 1000, None),
    "place": (["src/place"], 7200, 8925),  # storeys, floors of clouds, clouds that lie any way, roofs
    "search": (["src/search"], 5400, 6040),
    "match": (["src/match"], 1300, 1855),
    "pose": (["src/pose"], 2800, None),
    "verdict": (["src/verdict"], 900, None),
    "localizer": (["src/localizer"], 3300, 4215),  # other heights, storeys of clouds, verdicts on poses of others
    "map": (["src/map"], 4000, None),
    "compare": (["src/compare"], 2100, 2405),
    "io": (["src/io"], 5500, 6100),  # writes LAS, moves clouds with all their fields
    "io/bags": (["src/io/bags"], 1900, 2325),
    "io/e57, LAS": (["src/io/e57", "src/io/las_header.cpp"], 800, 1010),  # units and fields that LAS states, fields of E57
    "io/datasets": (["src/io/datasets"], 800, None),
    "view": (["src/view"], 2400, 2540),
    "eval": (["src/eval"], 600, None),
    "sim": (["src/sim"], 4100, None),
    "pcd_tools": (["pcd_tools"], 8000, 11540),  # the server is a module
}
PUBLIC_HEADERS = 22
ALL, ALL_LIMIT = 50000, 62640  # without the simulator


def sources(path):
    full = os.path.join(ROOT, path)
    if os.path.isfile(full):
        yield full
    for folder, _, names in os.walk(full):
        yield from (os.path.join(folder, name) for name in names if name.endswith((".h", ".cpp")))


def lines_of(path):
    with open(path, "rb") as file:
        return file.read().count(b"\n")


def main():
    room_of = {}
    for room, (paths, _, _) in ROOMS.items():  # the room of the longest path
        for path in sorted(paths):
            for file in sources(path):
                known = room_of.get(file)
                if known is None or len(path) > known[0]:
                    room_of[file] = (len(path), room)
    lines = dict.fromkeys(ROOMS, 0)
    headers = 0
    for file, (_, room) in room_of.items():
        lines[room] += lines_of(file)
        headers += room == "include"
    above = []
    print("| room | lines | budget | |\n|---|---|---|---|")
    rows = [(room, lines[room], budget, limit) for room, (_, budget, limit) in ROOMS.items()]
    rows.append(("all but sim", sum(lines.values()) - lines["sim"], ALL, ALL_LIMIT))
    rows.append(("public headers", headers, PUBLIC_HEADERS, PUBLIC_HEADERS))
    for name, count, budget, limit in rows:
        limit = limit or int(1.05 * budget)
        note = "" if count <= 1.05 * budget else f"{count - budget} above its budget"
        if count > limit:
            above.append(name)
            note = f"ABOVE ITS LIMIT of {limit}"
        print(f"| {name} | {count} | {budget} | {note} |")
    for name in above:
        print(f"{name} has more lines than its limit", file=sys.stderr)
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
