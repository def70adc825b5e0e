# SPDX-License-Identifier: BSD-3-Clause
"""view_open3d.py QUERY.pcd MAP.xvm: query and map in the window of Open3D (pip install open3d)."""
import importlib
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

import xview


def main(query_path: str, map_path: str) -> None:
    query, town = xview.read(query_path), xview.load_map(map_path)
    fix = xview.Localizer(town).localize(query)
    print(f"{fix.status}: {fix.reason}")
    open3d: Any = importlib.import_module("open3d")

    def coloured(points: NDArray[Any], color: tuple[float, float, float]) -> Any:
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points.astype(np.float64)))
        cloud.paint_uniform_color(color)
        return cloud

    scene = [coloured(town.points, (0.7, 0.7, 0.7))]
    if isinstance(query, xview.Recording) and fix.T_map_query is not None:
        seen = coloured(query.cloud()[0], (0.1, 0.7, 0.2) if fix.accepted else (0.9, 0.2, 0.1))
        scene.append(seen.transform(fix.T_map_query))
    open3d.visualization.draw_geometries(scene, window_name=fix.reason)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
