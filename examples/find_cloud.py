# SPDX-License-Identifier: BSD-3-Clause
"""Makes two clouds of one place and finds one in the other. Needs no data."""
import numpy as np

import xview

rng = np.random.default_rng(1)
posts = rng.uniform(-60, 60, (60, 2))  # x, y of posts on flat ground [m]
ground = np.c_[rng.uniform(-80, 80, (150000, 2)), rng.normal(0, 0.02, 150000)]
heights = rng.uniform(0, 4, 60 * 300)
trunks = np.c_[np.repeat(posts, 300, axis=0) + rng.normal(0, 0.05, (60 * 300, 2)), heights]
town = np.r_[ground, trunks]

yaw, shift = 2.0, np.array([12.0, -7.0, 0.5])  # where the query really is
R = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
near = town[np.linalg.norm(town[:, :2] - shift[:2], axis=1) < 45]
scan = (near + rng.normal(0, 0.02, near.shape) - shift) @ R  # p_map = R @ p_query + shift

fix = xview.Localizer(xview.Map.build(town)).localize(scan)
print(fix.status, "-", fix.reason)
print(fix.T_map_query)
