# SPDX-License-Identifier: BSD-3-Clause
"""Find where a robot is in a semantic map, from any view-point.

    import xview
    town = xview.load_map("town.xvm")                  # or xview.Map.build(points)
    fix = xview.Localizer(town, risk=0.01).localize(points)   # (N, 3) [m], z up
    if fix.accepted:
        print(fix.T_map_query)                         # p_map = T_map_query @ p_query
    else:
        print(fix.reason)

Metres, radians and seconds. Poses are float64 (4, 4) arrays T_target_source, which take points of
the source frame to the target frame. What cannot be read raises Error, what makes no sense
UsageError; a query that is not found is a Fix that is not accepted.
"""
from xview._xview import (
    Descriptors,
    Error,
    Fix,
    Graph,
    Localizer,
    Map,
    Recording,
    Tracker,
    UsageError,
    __version__,
    consensus,
    descriptors,
    evaluate,
    graph,
    load_map,
    match,
    read,
    simulate,
    walks,
)

__all__ = [
    "Descriptors",
    "Error",
    "Fix",
    "Graph",
    "Localizer",
    "Map",
    "Recording",
    "Tracker",
    "UsageError",
    "__version__",
    "consensus",
    "descriptors",
    "evaluate",
    "graph",
    "load_map",
    "match",
    "read",
    "simulate",
    "walks",
]
