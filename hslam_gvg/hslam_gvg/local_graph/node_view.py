"""What is announced of a node of the local graph."""

from collections.abc import Sequence

from hslam_gvg.local_graph.polyline import chord_bearing
from hslam_types.gvg_events import NodeKind, NodeView
from hslam_types.se2 import Array, wrap
from hslam_voronoi.branch_graph import Hub

BEYOND_M = 0.5
"""Bearings are taken at least so far beyond the node's clearance: nearer, the ways have hardly parted."""


def node_view(hub: Hub, paths: Sequence[Array], chord_m: float) -> tuple[NodeView, tuple[Array, ...]]:
    """Return the view of a node, and the paths of its branches in the order of the view's bearings (rad, ascending).

    A branch's bearing is that of its point at ``chord_m`` from the node, or beyond the node's clearance.
    """
    chord_m = max(chord_m, hub.clearance + BEYOND_M)
    branches = sorted((wrap(chord_bearing(path, chord_m)), i) for i, path in enumerate(paths))
    kind = NodeKind.BOUNDARY_POINT if len(branches) == 1 else NodeKind.MEET_POINT
    view = NodeView(kind, hub.x, hub.y, hub.clearance, tuple(bearing for bearing, _ in branches))
    return view, tuple(paths[i] for _, i in branches)
