#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes what `./run fuzz` reached into the table of docs/reliability.md: figures.py build-fuzz/findings

Rows of targets that have no log there stay as they are.
"""
import re
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs/reliability.md"


def figures(log):
    """Executions, seconds and edges of a log of libFuzzer; None if it was broken off before its end."""
    done = re.search(r"number_of_executed_units: (\d+)", log)
    seconds = re.search(r"Done \d+ runs in (\d+) second", log)
    edges = re.findall(r" cov: (\d+)", log)
    return (int(done[1]), int(seconds[1]), int(edges[-1])) if done and seconds and edges else None


def main(folder):
    lines = PAGE.read_text().splitlines()
    for log in sorted(Path(folder).glob("*.log")):
        found = figures(log.read_text(errors="replace"))
        rows = [i for i, line in enumerate(lines) if line.startswith(f"| `{log.stem}` |")]
        if not found or not rows:
            print(f"{log.stem}: no {'row in ' + PAGE.name if found else 'whole log'}", file=sys.stderr)
            continue
        name, inputs = lines[rows[0]].split(" | ")[:2]
        executions, seconds, edges = found
        lines[rows[0]] = f"{name} | {inputs} | {executions:,} | {seconds / 60:.0f} | {edges:,} |"
    PAGE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
