"""All scores of an exploration's graph against the truth."""

from dataclasses import dataclass

from hslam_report.explored import ExploredGraph
from hslam_report.isomorphism import embedding_of_explored, embedding_of_truth, isomorphism
from hslam_report.node_score import NodeMatches, match_nodes, precision_and_recall
from hslam_report.path_score import compare_paths
from hslam_report.visits import false_closures, true_closures
from hslam_sim.truth.gvg import TrueGvg


@dataclass(frozen=True)
class GraphScore:
    """The graph's part of a report; names as in report.json."""

    nodes: int
    edges: int
    true_nodes: int
    true_edges: int
    true_core_nodes: int
    node_precision: float
    node_recall: float
    edge_precision: float
    edge_recall: float
    isomorphic: bool
    """On worlds whose nodes are all core: an isomorphism of embedded graphs exists.  Elsewhere: every core node
    and every core path was found, and nothing else."""
    loop_closures_true: int
    loop_closures_false: int
    loop_closures_missed: int
    """Nodes the atlas has twice."""
    matches: NodeMatches


def score_graph(graph: ExploredGraph, truth: TrueGvg) -> GraphScore:
    """Return the scores of an explored graph."""
    matches = match_nodes(graph, truth)
    node_precision, node_recall = precision_and_recall(matches, graph, truth)
    paths = compare_paths(graph, truth, matches.core)
    if truth.all_core:
        same = isomorphism(embedding_of_explored(graph), embedding_of_truth(truth)) is not None
    else:
        same = node_precision == node_recall == paths.precision == paths.recall == 1.0
    return GraphScore(
        nodes=len(graph.nodes),
        edges=len(graph.edges),
        true_nodes=len(truth.nodes),
        true_edges=len(truth.edges),
        true_core_nodes=sum(node.core for node in truth.nodes),
        node_precision=node_precision,
        node_recall=node_recall,
        edge_precision=paths.precision,
        edge_recall=paths.recall,
        isomorphic=same,
        loop_closures_true=true_closures(graph),
        loop_closures_false=false_closures(graph),
        loop_closures_missed=len(matches.doubled),
        matches=matches,
    )
