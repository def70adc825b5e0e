#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes docs/results/verdict.md: what decides, and what is accepted of each make by weights that the others set.

    bench/regress.py --answers answers.jsonl
    bench/verdict_table.py table.csv --seeds 905 906 --qualities 0.83 1 0.6 --windows 5 --answers simulated
    bench/verdict_table.py others.csv --seeds 905 --styles forest motorway carpark warehouse home --windows 5 \\
        --answers others
    bench/verdict_page.py answers.jsonl simulated/*.jsonl others/*.jsonl

The model that is learned on the way is written to config/verdict.txt with --model.
"""
import argparse
import shutil
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TERMS = {
    "margin": "how far the best place stands out of the other places of the query: points and views",
    "inlier_ratio": "how closely points lie on points of their class, beside that of wrong places of the map",
    "overlap": "overlap of query and map, both ways; in rooms and of scans the ratio of inliers to self-consistency",
    "map_coverage": "share of the query that lies where the map was seen",
    "free_space": "what stands in the map, and rays of the query pass through",
    "wrong_place_above_null": "how closely wrong places of the map fit: all evidence says less there",
}
FEWEST = 20  # Answers of a make that has a line of its own.
HEAD = """# The verdict

Is the pose right? Six terms decide, for cameras and scans, streets and rooms, from the ground and from the air
([algorithm](../algorithm.md)). A bare graph has one, the margin of its vertices and how many of them
are found. Weights, in log odds per unit:

| term | weight | what it is |
|---|---|---|
"""
MIDDLE = """
{answers} answers, {right} right ones (3 m; indoors 0.5 m, on a desk 0.15 m) and {wrong} of wrong places or of places
that the map does not hold. **Each make of world and sensor is judged by weights and a calibration that the others
set.** Right ones that are accepted, and wrong ones, at a risk of 0.01:

| make | right | accepted | wrong | accepted |
|---|---|---|---|---|
"""
TAIL = """
Asked for other risks, all makes together:

| risk | right ones accepted | wrong ones accepted | share of wrong ones among accepted |
|---|---|---|---|
{risks}
Confidence is below what it could claim: 1.7 in log odds are held back for makes that none of these shows. It speaks of
queries of which half are out of the map. Worlds of copies (streets or rooms of a few moulds) are no part of this;
`xview info` says whether a map is one.

**Left out by make are weights and calibration alone.** The terms, the constants in them and what is held back were
chosen by comparing such tables of these same answers, and styles of one simulator count as makes. A make that nobody
has looked at may do worse.

The part of `overlap` for rooms and scans came after these tables, chosen on four offices of like rooms: of 742 windows
of wrong places there 7 are accepted instead of 16, and of 162 right ones 101 instead of 103; of 564 windows of four
fresh offices that are out of the map 6 are. `./run regress` has 1132 right ones of 1209 accepted instead of 1133, and
no wrong one.

Weak are offices, where rooms resemble each other within one floor and between buildings; windows of 15 m that look
aside in a grid of streets; motorways and car parks of another make. What is refused there has another place that fits
about as well.

Written by `bench/verdict_page.py`, which names the commands.
"""


def learned(answers, model):
    """Lines of the table of `xview learn --verdict`, as lists of cells."""
    said = subprocess.run([str(ROOT / "build/xview"), "learn", "--verdict", *answers, str(model)], check=True,
                          capture_output=True, text=True).stdout
    lines = [line.strip("| ").split(" | ") for line in said.splitlines() if line.startswith("| ")]
    return [(cells[0], [int(cell) for cell in cells[1:]]) for cells in lines if cells[1].isdigit()]


def page(rows, weights):
    text = HEAD + "".join(f"| `{term}` | {weights[term]} | {what} |\n" for term, what in TERMS.items())
    whole = dict(rows)["all"]
    text += MIDDLE.format(answers=whole[0] + whole[4], right=whole[0], wrong=whole[4])
    rest = [0] * 8
    for make, numbers in rows[:-1]:
        make = {"real_strangers": "recordings in the maps of others"}.get(make, make)
        if numbers[0] + numbers[4] < FEWEST:
            rest = [a + b for a, b in zip(rest, numbers)]
        else:
            text += f"| {make} | {numbers[0]} | {numbers[2]} | {numbers[4]} | {numbers[6]} |\n"
    for make, numbers in (("others, real ones", rest), ("**all**", whole)):
        text += f"| {make} | {numbers[0]} | {numbers[2]} | {numbers[4]} | {numbers[6]} |\n"
    risks = ""
    for i, risk in enumerate(("0.1", "0.01", "0.001"), 1):
        right, wrong = whole[i] / whole[0], whole[4 + i] / whole[4]
        risks += f"| {risk} | {right:.1%} | {whole[4 + i]} of {whole[4]} | {wrong / (right + wrong):.2%} |\n"
    return text + TAIL.format(risks=risks)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("answers", nargs="+")
    parser.add_argument("--model", action="store_true", help="keep the weights as config/verdict.txt")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "verdict.txt"
        rows = learned(arguments.answers, model)
        named = (line.split() for line in model.read_text().splitlines() if line.startswith("registered."))
        weights = {name.split(".")[1]: value for name, value in named}
        if arguments.model:
            shutil.copy(model, ROOT / "config/verdict.txt")
    (ROOT / "docs/results/verdict.md").write_text(page(rows, weights))


if __name__ == "__main__":
    main()
