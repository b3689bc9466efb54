"""Graph, edge-maps and open questions as rows of the atlas file's tables."""

import json
import sqlite3
from collections.abc import Mapping

import numpy as np

from hslam_atlas.graph import AtlasGraph, Branch, Edge, EdgeEnd, Link, Node
from hslam_atlas.questions import Question
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2


def write_graph(db: sqlite3.Connection, graph: AtlasGraph) -> None:
    """Write the nodes, edges and links touched since the last save."""
    for node_id in sorted(graph.changed_nodes):
        _write_node(db, node_id, graph.nodes.get(node_id))
    for edge_id in sorted(graph.changed_edges):
        _write_edge(db, edge_id, graph.edges.get(edge_id))
    for link_id in sorted(graph.changed_links):
        _write_link(db, link_id, graph.links.get(link_id))


def read_graph(db: sqlite3.Connection) -> AtlasGraph:
    """Return the graph; its next ids are still to be set."""
    graph = AtlasGraph()
    for node_id, kind, clearance in db.execute("SELECT id, kind, clearance FROM nodes ORDER BY id"):
        graph.nodes[node_id] = Node(node_id, NodeKind(kind), clearance)
    for node_id, key, bearing, edge, seen, missed, attempts, given_up in db.execute(
        "SELECT * FROM branches ORDER BY node, key"
    ):
        branch = Branch(key, bearing, edge, seen, missed, attempts, bool(given_up))
        graph.nodes[node_id].branches[key] = branch
    for node_id, sequence, stamp_ns in db.execute("SELECT * FROM visits ORDER BY node, sequence"):
        graph.nodes[node_id].visits.append((sequence, stamp_ns))
    for row in db.execute("SELECT * FROM edges ORDER BY id"):
        graph.put_edge(_edge_from_row(row))
    for link_id, node0, node1, pose, length in db.execute("SELECT * FROM links ORDER BY id"):
        graph.put_link(Link(link_id, node0, node1, _pose_from_blob(pose), length))
    return graph


def write_maps(db: sqlite3.Connection, maps: Mapping[int, bytes | None]) -> None:
    """Write edge-maps by edge; None takes one out."""
    for edge_id, blob in maps.items():
        if blob is None:
            db.execute("DELETE FROM edge_maps WHERE edge = ?", (edge_id,))
        else:
            db.execute("INSERT OR REPLACE INTO edge_maps VALUES (?, ?)", (edge_id, blob))


def write_questions(db: sqlite3.Connection, questions: list[Question]) -> None:
    """Replace the open questions by these."""
    db.execute("DELETE FROM questions")
    for q in sorted(questions, key=lambda q: (q.node, q.other)):
        compared = json.dumps(sorted(q.compared))
        pose, maps = _pose_to_blob(q.node_in_other), json.dumps(q.map_evidence)
        row = (q.node, q.other, pose, q.place_evidence, maps, compared)
        db.execute("INSERT OR REPLACE INTO questions VALUES (?, ?, ?, ?, ?, ?)", row)


def read_questions(db: sqlite3.Connection) -> list[Question]:
    """Return the open questions."""
    return [
        Question(
            node,
            other,
            _pose_from_blob(pose),
            place,
            tuple(json.loads(maps)),
            frozenset((a, b) for a, b in json.loads(compared)),
        )
        for node, other, pose, place, maps, compared in db.execute("SELECT * FROM questions ORDER BY node, other")
    ]


def _write_node(db: sqlite3.Connection, node_id: int, node: Node | None) -> None:
    for table, key in (("nodes", "id"), ("branches", "node"), ("visits", "node")):
        db.execute(f"DELETE FROM {table} WHERE {key} = ?", (node_id,))  # noqa: S608 - names from the line above
    if node is None:
        return
    db.execute("INSERT INTO nodes VALUES (?, ?, ?)", (node_id, int(node.kind), node.clearance_m))
    for b in node.branches.values():
        row = (node_id, b.key, b.bearing, b.edge, b.seen, b.missed, b.attempts, int(b.given_up))
        db.execute("INSERT INTO branches VALUES (?, ?, ?, ?, ?, ?, ?, ?)", row)
    for sequence, stamp_ns in node.visits:
        db.execute("INSERT INTO visits VALUES (?, ?, ?)", (node_id, sequence, stamp_ns))


def _write_edge(db: sqlite3.Connection, edge_id: int, edge: Edge | None) -> None:
    db.execute("DELETE FROM edges WHERE id = ?", (edge_id,))
    if edge is None:
        return
    ends = [value for end in edge.ends for value in (end.node, end.branch, _pose_to_blob(end.frame_in_node))]
    sizes = (edge.terminal_x, edge.terminal_variance, edge.path_length_m)
    row = (edge_id, *ends, *sizes, json.dumps(edge.traversals))
    db.execute("INSERT INTO edges VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", row)


def _edge_from_row(row: tuple[object, ...]) -> Edge:
    edge_id, n0, b0, f0, n1, b1, f1, terminal_x, variance, length, traversals = row
    ends = (EdgeEnd(n0, b0, _pose_from_blob(f0)), EdgeEnd(n1, b1, _pose_from_blob(f1)))  # type: ignore[arg-type]
    return Edge(edge_id, ends, terminal_x, variance, length, tuple(json.loads(traversals)))  # type: ignore[arg-type]


def _write_link(db: sqlite3.Connection, link_id: int, link: Link | None) -> None:
    db.execute("DELETE FROM links WHERE id = ?", (link_id,))
    if link is not None:
        row = (link_id, link.from_node, link.to_node, _pose_to_blob(link.to_in_from), link.path_length_m)
        db.execute("INSERT INTO links VALUES (?, ?, ?, ?, ?)", row)


def _pose_to_blob(pose: UncertainPose) -> bytes:
    return np.concatenate((np.array(pose.pose), pose.covariance.ravel())).astype("<f8").tobytes()


def _pose_from_blob(blob: bytes) -> UncertainPose:
    values = np.frombuffer(blob, "<f8")
    x, y, theta = values[:3].tolist()
    return UncertainPose(SE2(x, y, theta), values[3:].reshape(3, 3).astype(np.float64))
