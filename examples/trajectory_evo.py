# SPDX-License-Identifier: BSD-3-Clause
"""trajectory_evo.py RECORDING MAP.xvm OUT.tum: accepted windows as a TUM trajectory for evo.

    evo_ape tum groundtruth.txt OUT.tum --t_max_diff 0.05
"""
import sys

import numpy as np
from numpy.typing import NDArray

import xview


def quaternion(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """x, y, z, w of a rotation matrix: the dominant eigenvector (Bar-Itzhack 2000)."""
    a, b = R, R.T
    K = np.empty((4, 4))
    K[:3, :3] = a + b - np.eye(3) * np.trace(a)
    K[3, :3] = K[:3, 3] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    K[3, 3] = np.trace(a)
    q: NDArray[np.float64] = np.linalg.eigh(K)[1][:, -1]
    return q if q[3] >= 0 else -q


def main(recording_path: str, map_path: str, out: str) -> int:
    recording = xview.read(recording_path)
    if not isinstance(recording, xview.Recording):
        raise xview.UsageError(f"{recording_path} is no recording")
    fixes = xview.Localizer(xview.load_map(map_path)).localize_windows(recording, 30, 10)
    stamps = recording.stamps
    lines = []
    for fix in fixes:
        if not fix.accepted or fix.T_map_sensor is None:
            continue  # nobody invents a pose
        stamp = stamps[fix.to_dict()["query"]["last_index"]]
        numbers = (*fix.T_map_sensor[:3, 3], *quaternion(fix.T_map_sensor[:3, :3]))
        lines.append(f"{stamp:.6f} " + " ".join(f"{n:.9g}" for n in numbers) + "\n")
    with open(out, "w", encoding="ascii") as file:
        file.writelines(lines)
    print(f"{len(lines)} of {len(fixes)} windows accepted: {out}")
    return 0 if lines else 3


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
