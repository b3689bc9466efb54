"""Writes graph, edge-maps and open questions as rows of the atlas file's tables."""

import json
import sqlite3
from collections.abc import Mapping

from hslam_atlas import pose_blob
from hslam_atlas.graph import AtlasGraph, Edge, Link, Node
from hslam_atlas.questions import Question


def write_graph(db: sqlite3.Connection, graph: AtlasGraph) -> None:
    """Write the nodes, edges and links touched since the last save."""
    for node_id in sorted(graph.changed_nodes):
        _write_node(db, node_id, graph.nodes.get(node_id))
    for edge_id in sorted(graph.changed_edges):
        _write_edge(db, edge_id, graph.edges.get(edge_id))
    for link_id in sorted(graph.changed_links):
        _write_link(db, link_id, graph.links.get(link_id))


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
        pose, maps = pose_blob.encode(q.node_in_other), json.dumps(q.map_evidence)
        row = (q.node, q.other, pose, q.place_evidence, maps, compared)
        db.execute("INSERT OR REPLACE INTO questions VALUES (?, ?, ?, ?, ?, ?)", row)


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
    ends = [value for end in edge.ends for value in (end.node, end.branch, pose_blob.encode(end.frame_in_node))]
    sizes = (edge.terminal_x, edge.terminal_variance, edge.path_length_m)
    row = (edge_id, *ends, *sizes, json.dumps(edge.traversals))
    db.execute("INSERT INTO edges VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", row)


def _write_link(db: sqlite3.Connection, link_id: int, link: Link | None) -> None:
    db.execute("DELETE FROM links WHERE id = ?", (link_id,))
    if link is not None:
        row = (link_id, link.from_node, link.to_node, pose_blob.encode(link.to_in_from), link.path_length_m)
        db.execute("INSERT INTO links VALUES (?, ?, ?, ?, ?)", row)
