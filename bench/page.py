#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What a page of `xview view` (match, evaluate, diff ...) costs and does in headless Chromium.

For each page: its size, the time from asking for it to the end of the first draw, the median time of a frame while
the camera goes round the map, from far and from near, with the points that are drawn then and when it rests, messages
on the console, and requests to anywhere but the page itself. WebGL runs on the processor (SwiftShader): a graphics card is faster.
"""
import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

# Goes round, first as the page opens, then near; after that the page says how long the frames took.
ROUND = """<script>
addEventListener('load', () => {
  const frames = [], turn = distance => {
    const start = camera.position.clone().sub(controls.target).setLength(distance), took = [];
    detail = 1;
    for (let i = 0; i < 24; ++i) {
      camera.position.copy(start).applyAxisAngle(new THREE.Vector3(0, 0, 1), i * Math.PI / 12).add(controls.target);
      controls.update();
      const began = performance.now();
      draw();
      took.push(performance.now() - began);
    }
    const points = renderer.info.render.points;
    moving = false;
    const began = performance.now();
    draw();
    frames.push([took.slice(8).sort((a, b) => a - b)[8], points, performance.now() - began, renderer.info.render.points]);
  };
  turn(camera.position.distanceTo(controls.target));
  const fullest = clouds.reduce((a, b) => a.userData.count > b.userData.count ? a : b, {userData: {count: 0}});
  if (fullest.position) controls.target.copy(fullest.position).addScalar(fullest.userData.size / 2);
  turn(scene.radius / 6);
  document.documentElement.dataset.frames = JSON.stringify(frames);
});
</script></body>"""


def chromium(arguments, page, *more):
    command = [arguments.chromium, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
               "--enable-unsafe-swiftshader", "--window-size=1280,800", "--enable-logging=stderr", *more, "--dump-dom",
               page.resolve().as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def requests_in(log):
    """Addresses that were asked for, but for the page, and for those that Chromium asks for by itself."""
    found = set(re.findall(r'"url":"([a-z]+://[^"]+)"', log))
    return sorted(url for url in found if not re.match(r"file:|chrome|https?://([a-z0-9.-]+\.)?(google|googleapis|gvt1)\.com", url))


def measure(arguments, page):
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "net.json"
        draws = []
        for _ in range(arguments.runs):
            shown = chromium(arguments, page, f"--log-net-log={log}")
            draws.append(int(re.search(r'data-first-draw="(\d+)"', shown.stdout).group(1)))
        turning = Path(folder) / "turning.html"
        turning.write_text(page.read_text().replace("</body>", ROUND))
        turned = chromium(arguments, turning, "--virtual-time-budget=1")
        frames = json.loads(re.search(r'data-frames="([^"]+)"', turned.stdout).group(1))
        said = [line for line in shown.stderr.splitlines() if ":CONSOLE" in line]
        row = {"page": page.name, "MB": f"{page.stat().st_size / 1e6:.1f}", "first draw ms": sorted(draws)[len(draws) // 2]}
        for where, (moving_ms, moving, resting_ms, resting) in zip(("far", "near"), frames):
            row[f"{where}: frame ms (points)"] = f"{moving_ms:.0f} ({moving})"
            row[f"{where}, at rest"] = f"{resting_ms:.0f} ({resting})"
        return {**row, "console": len(said), "requests": " ".join(requests_in(log.read_text())) or 0}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="+", type=Path, metavar="PAGE.html")
    parser.add_argument("--runs", type=int, default=3, help="first draws, of which the median counts; default 3")
    parser.add_argument("--chromium", default="chromium", help="the browser; default chromium")
    arguments = parser.parse_args()
    rows = [measure(arguments, page) for page in arguments.pages]
    for cells in (rows[0], ["---"] * len(rows[0]), *(row.values() for row in rows)):
        print("| " + " | ".join(map(str, cells)) + " |")


if __name__ == "__main__":
    sys.exit(main())
