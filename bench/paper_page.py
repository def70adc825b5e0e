# SPDX-License-Identifier: BSD-3-Clause
"""Charts as SVG and tables as Markdown for the page of the paper's experiments."""
import math
import re
import textwrap
from collections import namedtuple
from html import escape

# y over x, joined by a line; dashes for what others have measured.
Curve = namedtuple("Curve", "name points color dashed", defaults=(False,))

ORANGE, BLUE, GREY = "#d95f02", "#1f78b4", "#777777"
SHADES = ("#c6dbef", "#9ecae1", "#6baed6", "#3182bd", "#08519c", "#08306b")
WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 640, 360, 56, 40, 172, 46


def ticks(low, high, count=6):
    """Round numbers from low to high."""
    rough = (high - low) / count
    power = 10 ** math.floor(math.log10(rough))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough)
    first = math.ceil(low / step - 1e-9)
    return [step * i for i in range(first, math.floor(high / step + 1e-9) + 1)]


class Axis:
    """A value to a pixel; logarithmic if asked."""

    def __init__(self, low, high, start, end, log=False):
        self.to = (lambda v: math.log(v)) if log else (lambda v: v)
        self.low, self.high, self.start, self.end = self.to(low), self.to(high), start, end

    def __call__(self, value):
        return self.start + (self.to(value) - self.low) / (self.high - self.low) * (self.end - self.start)


def text(x, y, said, anchor="middle", size=12, more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" {more}>{escape(said)}</text>'


def line(x1, y1, x2, y2, color, more=""):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{color}" {more}/>'


def chart(title, x_label, y_label, curves, x_ticks=None, log=False, x_range=None):
    """Percents over something, with a legend at the right."""
    xs = [x for curve in curves for x, _ in curve.points]
    low, high = x_range or (min(xs), max(xs))
    x = Axis(low, high, LEFT, WIDTH - RIGHT, log)
    y = Axis(0, 100, HEIGHT - BOTTOM, TOP)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
             'font-family="sans-serif" fill="#222">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
             text(LEFT, 22, title, "start", 15, 'font-weight="bold"')]
    for value in range(0, 101, 20):
        parts += [line(LEFT, y(value), WIDTH - RIGHT, y(value), "#dddddd"), text(LEFT - 8, y(value) + 4, str(value), "end")]
    for value in x_ticks or ticks(low, high):
        parts += [line(x(value), y(0), x(value), y(0) + 5, "#222"), text(x(value), y(0) + 19, f"{value:g}")]
    parts += [text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 8, x_label),
              text(16, (TOP + HEIGHT - BOTTOM) / 2, y_label, more=f'transform="rotate(-90 16 {(TOP + HEIGHT - BOTTOM) / 2})"')]
    for number, curve in enumerate(curves):
        dash = 'stroke-dasharray="5 4"' if curve.dashed else ""
        path = " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in curve.points)
        parts.append(f'<polyline points="{path}" fill="none" stroke="{curve.color}" stroke-width="2" {dash}/>')
        if len(curve.points) <= 10 and not curve.dashed:
            parts += [f'<circle cx="{x(a):.1f}" cy="{y(b):.1f}" r="3" fill="{curve.color}"/>' for a, b in curve.points]
        at = TOP + 10 + 19 * number
        parts += [line(WIDTH - RIGHT + 10, at - 4, WIDTH - RIGHT + 32, at - 4, curve.color, f'stroke-width="2" {dash}'),
                  text(WIDTH - RIGHT + 38, at, curve.name, "start", 11)]
    return "\n".join([*parts, "</svg>", ""])


def table(rows):
    """The first row is the heading."""
    head, *body = [[str(cell).replace("|", "/") for cell in row] for row in rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *body])


def wrapped(page):
    """A page of Markdown whose paragraphs and items of lists have lines of at most 120 characters."""
    def block(lines):
        if re.match(r"\n*([#|!]|```|    )", lines):  # headings, tables, pictures, code
            return lines
        items = re.split(r"\n(?=\* )", lines)
        return "\n".join(textwrap.fill(" ".join(item.split()), 120, subsequent_indent="  " if item.startswith("* ") else "",
                                       break_long_words=False, break_on_hyphens=False) for item in items)
    return "\n\n".join(map(block, page.rstrip("\n").split("\n\n"))) + "\n"


def percent(share):
    return "–" if share is None or math.isnan(share) else f"{100 * share:.0f} %"
