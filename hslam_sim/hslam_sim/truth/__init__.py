"""The true reduced GVG of a world, computed from its geometry: what a run is scored against.

Nothing a node runs may import this package; only the report and the command line do.
"""

from hslam_sim.truth.draw import draw_true_gvg
from hslam_sim.truth.gvg import TrueEdge, TrueGvg, TrueKind, TrueNode
from hslam_sim.truth.rules import Rules
from hslam_sim.truth.true_gvg import true_gvg

__all__ = ["Rules", "TrueEdge", "TrueGvg", "TrueKind", "TrueNode", "draw_true_gvg", "true_gvg"]
