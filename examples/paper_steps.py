# SPDX-License-Identifier: BSD-3-Clause
"""The steps of the X-View paper (Gawel et al., RA-L 2018) one by one, on a simulated town."""
import numpy as np

import xview

# A seeded town: a drive with the camera forward, and the same streets seen looking back.
drives = xview.simulate(seed=7, route_length_m=150, sessions__aerial=False)
forward, rear = drives["forward"], drives["rear"]
assert forward.truth is not None and rear.truth is not None
print(f"{forward}: {len(forward.classes)} classes, images of {forward.depth(0).shape}")

# Section III-A and B: blobs of one class become vertices, merged over frames; near ones get edges.
town, query = xview.graph(forward), xview.graph(rear)
print(f"map {town}, query {query}")

# Section III-C: a vertex is described by the classes that random walks from it meet.
vertex = 0
print(f"walks from vertex {vertex}, a {town.classes[int(town.labels[vertex])]}:")
for word, count in xview.walks(town, vertex, walks__num_walks=200)[:5]:
    print(f"  {count} x", " - ".join(town.classes[label] for label in word))

# Section III-D: the k most similar vertices of the map for every vertex of the query.
pairs, similarity = xview.match(query, town, match__candidates=5)
print(f"{len(pairs)} putative correspondences, similarity up to {similarity.max():.2f}")

# Section III-E: the pose that most of them agree on. The localizer adds a search over all of the map,
# a registration, a covariance and a verdict.
T_true = rear.truth[-1] @ np.linalg.inv(rear.poses[-1])  # T_map_query
pose, kept = xview.consensus(query, town, pairs)
if pose is None:
    print("consensus: no pose")
else:
    off = np.linalg.norm(pose[:3, 3] - T_true[:3, 3])
    print(f"consensus: {len(kept)} pairs agree, origin {off:.2f} m from the truth")

localizer = xview.Localizer(xview.Map.build(forward), risk=0.01)
fix = localizer.localize(rear)
print(f"localizer: {fix.status}: {fix.reason}")
if fix.T_map_sensor is not None:
    off = np.linalg.norm(fix.T_map_sensor[:3, 3] - rear.truth[-1][:3, 3])
    print(f"  {off:.2f} m from the truth, p_wrong {fix.p_wrong:.1e}")

# Windows of 15 frames, scored as in section IV.
fixes = localizer.localize_windows(rear, window=15, stride=10)
truth = [rear.truth[f.to_dict()["query"]["last_index"]] for f in fixes]
scores = xview.evaluate(fixes, truth, within_m=20)
print(f"{scores['queries']} windows: precision {scores['precision']}, recall {scores['recall']}")
