"""Draw an atlas by itself."""

from pathlib import Path

from hslam_atlas.picture import composed, parts
from hslam_atlas.pose_graph import optimised
from hslam_atlas.state import AtlasState
from hslam_bringup.errors import RunError
from hslam_report.atlas_figure import FORMATS, DrawnEdge, DrawnNode, atlas_figure, save_drawing
from hslam_types.gvg_events import NodeKind


def plot(state: AtlasState, out: Path, *, is_chained: bool) -> str:
    """Draw the largest connected part of an atlas to ``out``; return what was drawn, in words.

    Raises RunError where the name's ending is of no format, or the file cannot be written.
    """
    if out.suffix not in FORMATS:
        raise RunError(f"--out must end in one of {', '.join(FORMATS)}, not '{out.name}'")
    graph, divided = state.graph, parts(state.graph)
    anchor = divided[0][0]
    picture = composed(graph, state.maps, anchor) if is_chained else optimised(graph, state.maps, anchor, state.config)
    nodes = [
        DrawnNode(
            node,
            (pose.x, pose.y),
            picture.node_covariances[node][:2, :2],
            graph.nodes[node].kind is NodeKind.BOUNDARY_POINT,
            sum(branch.unexplored for branch in graph.nodes[node].branches.values()),
        )
        for node, pose in picture.nodes.items()
    ]
    edges = [
        DrawnEdge(
            edge,
            (graph.edges[edge].ends[0].node, graph.edges[edge].ends[1].node),
            frame,
            picture.landmarks[edge],
            state.maps.get(edge).covariance,
        )
        for edge, frame in picture.edge_frames.items()
    ]
    how = "along shortest chains" if is_chained else "by least squares"
    said = f"{len(nodes)} nodes, {len(edges)} edges, {sum(len(edge.landmarks) for edge in edges)} landmarks, {how}"
    if len(divided) > 1:
        said += f"; {len(divided) - 1} smaller parts are left out"
    figure = atlas_figure(nodes, edges, said)
    try:
        save_drawing(figure, out)
    except OSError as error:
        raise RunError(f"cannot draw to {out}: {error.strerror or error}") from error
    return said
