"""Graph and open questions from the rows of an atlas file: whole, or refused by table and row.

What the tables say of each other must agree, too: an id that leads nowhere would end the robot's run much later.
"""

import sqlite3
from collections.abc import Iterable

from hslam_atlas import edge_map_blob
from hslam_atlas.errors import ContentError
from hslam_atlas.graph import AtlasGraph, Branch, Edge, EdgeEnd, Link, Node
from hslam_atlas.missions.destination import Destination
from hslam_atlas.places import from_json
from hslam_atlas.questions import Question
from hslam_atlas.table_row import LAST_NUMBER, TableRow, is_count, layout, layouts, rows
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import NodeKind


def check_tables(db: sqlite3.Connection) -> None:
    """Raise ContentError unless the tables have the columns of this version."""
    for table, expected in layouts().items():
        found = layout(db, table)
        if not found.columns:
            raise ContentError(f"table {table} is missing")
        if found != expected:
            names = ascii(", ".join(found.columns))
            raise ContentError(f"table {table} has the columns {names} instead of {', '.join(expected.columns)}")


def read_graph(db: sqlite3.Connection) -> AtlasGraph:
    """Return the graph, its next ids set; raises ContentError."""
    graph = AtlasGraph()
    for row in rows(db, "nodes"):
        node_id = row.integer("id")
        kind = NodeKind(row.integer("kind", min(NodeKind), max(NodeKind)))
        graph.nodes[node_id] = Node(node_id, kind, row.real("clearance", 0.0))
    occupied = _read_branches(db, graph)
    for row in rows(db, "visits"):
        visit = row.integer("sequence", high=LAST_NUMBER), row.integer("stamp_ns", high=LAST_NUMBER)
        _node(row, "node", graph).visits.append(visit)
    for row in rows(db, "edges"):
        edge = _edge(row, graph)
        for number, end in enumerate(edge.ends):
            if occupied.pop((end.node, end.branch), (None,))[0] != edge.id:
                raise row.broken(f"branch{number}", f"is no branch of node {end.node} that says so too")
        graph.put_edge(edge)
    for edge_id, row in occupied.values():
        raise row.broken("edge", f"is no edge here: edge {edge_id} does not begin at this branch")
    for row in rows(db, "links"):
        start, stop = _node(row, "node0", graph), _node(row, "node1", graph)
        link = Link(row.integer("id"), start.id, stop.id, row.pose("pose"), row.real("path_length", 0.0))
        graph.put_link(link)
    _check_maps(db, graph)
    graph.resume(_next_ids(db, graph))
    return graph


def read_questions(db: sqlite3.Connection, graph: AtlasGraph) -> list[Question]:
    """Return the open questions about the nodes of a graph; raises ContentError."""
    return [
        Question(
            _node(row, "node", graph).id,
            _node(row, "other", graph).id,
            row.pose("pose"),
            row.real("place_evidence"),
            row.reals("map_evidence") or (0.0,),
            row.pairs("compared"),
        )
        for row in rows(db, "questions")
    ]


def read_map(db: sqlite3.Connection, edge_id: int) -> EdgeMap | None:
    """Return an edge's map, None if there is none; raises ContentError."""
    found = db.execute("SELECT edge, map FROM edge_maps WHERE edge = ?", (edge_id,)).fetchone()
    return None if found is None else _map(TableRow("edge_maps", ("edge",), {"edge": found[0], "map": found[1]}))


def read_counts(db: sqlite3.Connection) -> dict[str, int]:
    """Return the counts last saved, empty for a new atlas; raises ContentError."""
    row = read_meta(db, "counts")
    if row is None:
        return {}
    counts = row.from_json("value")
    if not isinstance(counts, dict) or not all(is_count(count) for count in counts.values()):
        raise row.broken("value", "is no set of counts")
    return counts


def read_places(db: sqlite3.Connection) -> dict[str, Destination]:
    """Return the places that have a name; raises ContentError."""
    row = read_meta(db, "places")
    if row is None:
        return {}
    places = from_json(row.from_json("value"))
    if places is None:
        raise row.broken("value", "is no set of named places")
    return places


def read_meta(db: sqlite3.Connection, key: str) -> TableRow | None:
    """Return the row of what is kept by name, None if there is none; raises ContentError."""
    return next((row for row in rows(db, "meta") if row.values["key"] == key), None)


def _read_branches(db: sqlite3.Connection, graph: AtlasGraph) -> dict[tuple[int, int], tuple[int, TableRow]]:
    """Read the branches; return those that carry an edge, by node and key, with its id."""
    occupied = {}
    for row in rows(db, "branches"):
        node, key = _node(row, "node", graph), row.integer("key")
        edge = None if row.values["edge"] is None else row.integer("edge")
        seen, missed, attempts = row.integer("seen"), row.integer("missed"), row.integer("attempts")
        given_up = bool(row.integer("given_up", high=1))
        node.branches[key] = Branch(key, row.real("bearing"), edge, seen, missed, attempts, given_up)
        if edge is not None:
            occupied[node.id, key] = edge, row
    return occupied


def _edge(row: TableRow, graph: AtlasGraph) -> Edge:
    first, second = (
        EdgeEnd(_node(row, f"node{end}", graph).id, row.integer(f"branch{end}"), row.pose(f"frame{end}"))
        for end in (0, 1)
    )
    traversals = row.integers("traversals")
    if not traversals:
        raise row.broken("traversals", "names no drive")
    sizes = row.real("terminal_x"), row.real("terminal_variance"), row.real("path_length", 0.0)
    return Edge(row.integer("id"), (first, second), *sizes, traversals)


def _node(row: TableRow, column: str, graph: AtlasGraph) -> Node:
    node = graph.nodes.get(row.integer(column))
    if node is None:
        raise row.broken(column, "is no node")
    return node


def _map(row: TableRow) -> EdgeMap:
    try:
        return edge_map_blob.decode(row.blob("map"))
    except ContentError as error:
        raise row.broken("map", str(error)) from error


def _check_maps(db: sqlite3.Connection, graph: AtlasGraph) -> None:
    """Every edge has a map, every map an edge, and each can be read; none of them is kept."""
    bare = set(graph.edges)
    for row in rows(db, "edge_maps"):
        edge_id = row.integer("edge")
        if edge_id not in bare:
            raise row.broken("edge", "is no edge")
        bare.remove(edge_id)
        _map(row)
    if bare:
        raise ContentError(f"table edge_maps has no row for edge {min(bare)}")


def _next_ids(db: sqlite3.Connection, graph: AtlasGraph) -> list[int]:
    """Return the ids that the next node, edge and link will get."""
    kinds: tuple[Iterable[int], ...] = (graph.nodes, graph.edges, graph.links)
    least = [max(ids, default=-1) + 1 for ids in kinds]
    row = read_meta(db, "next_ids")
    if row is None:
        if any(least):
            raise ContentError("table meta has no row next_ids")
        return least
    found = list(row.integers("value"))
    if len(found) != len(least) or any(a < b for a, b in zip(found, least, strict=True)):
        raise row.broken("value", f"are no ids that come after those there are, {least} at least")
    return found
