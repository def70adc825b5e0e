# SPDX-License-Identifier: BSD-3-Clause
"""plot_fix.py QUERY MAP OUT.png: the map from above, the query at its pose, and how sure that is.

QUERY and MAP are whatever `xview localize` takes. Needs matplotlib (apt install python3-matplotlib).
"""
import importlib
import sys
from typing import Any

from numpy.typing import NDArray

import xview


def cloud_of(thing: "xview.Recording | xview.Graph | xview.Map") -> NDArray[Any]:
    """(N, 3) [m] in the frame of the thing."""
    if isinstance(thing, xview.Recording):
        return thing.cloud(voxel_m=0.3)[0]
    if isinstance(thing, xview.Map) and len(thing.points) > 0:
        return thing.points
    return thing.graph.positions if isinstance(thing, xview.Map) else thing.positions


def main(query_path: str, map_path: str, out: str) -> int:
    query, town = xview.read(query_path), xview.read(map_path)
    if not isinstance(town, xview.Map):
        town = xview.Map.build(town)
    fix = xview.Localizer(town).localize(query)
    print(f"{fix.status}: {fix.reason}")

    importlib.import_module("matplotlib").use("Agg")  # a file, no window
    plt: Any = importlib.import_module("matplotlib.pyplot")
    _, axes = plt.subplots(figsize=(9, 9))
    points = cloud_of(town)
    axes.scatter(points[:, 0], points[:, 1], s=0.2, c="0.75", label="map")
    if fix.T_map_query is not None and fix.T_map_sensor is not None:
        seen = cloud_of(query) @ fix.T_map_query[:3, :3].T + fix.T_map_query[:3, 3]
        axes.scatter(seen[:, 0], seen[:, 1], s=0.2, c="tab:blue", label="query")
        axes.plot(*fix.T_map_sensor[:2, 3], "g*" if fix.accepted else "rx", ms=14, label=fix.status)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title(fix.reason, fontsize=8)
    axes.legend(markerscale=1, loc="upper right")
    plt.savefig(out, dpi=120)
    return 0 if fix.accepted else 3


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
