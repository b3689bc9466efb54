"""The graph of the atlas: nodes with cyclically ordered branches, edges that tie branches, links that tie nodes.

A node has its own frame: origin at the meet point, axes fixed by its first visit.  Every edge end knows the pose,
with covariance, of its edge frame in its node's frame, so that chaining edges gives any node in any other node's
frame.  Nothing is kept in a global frame.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.gvg_events import NodeKind
from hslam_types.se2 import SE2, wrap


@dataclass(slots=True)
class Branch:
    """One edge's beginning at a node."""

    key: int
    bearing: float
    """Direction in the node's frame (rad)."""
    edge: int | None = None
    seen: int = 1
    missed: int = 0
    attempts: int = 0
    """Drives into it that led nowhere new."""
    given_up: bool = False
    unseen: int = field(default=0, compare=False)
    """Visits in a row that did not show it; not kept in the file."""

    def give_up_if_absent(self) -> None:
        """Give an unexplored branch up that most visits did not show."""
        self.given_up |= self.edge is None and self.missed >= 2 and self.missed > self.seen

    def fail(self, most: int) -> None:
        """Count a drive into it that led nowhere new; after ``most`` of them an unexplored branch is given up."""
        self.attempts += 1
        self.given_up |= self.edge is None and self.attempts >= most

    @property
    def unexplored(self) -> bool:
        """Whether it still asks to be driven."""
        return self.edge is None and not self.given_up


@dataclass(slots=True)
class Node:
    """A meet point or boundary point."""

    id: int
    kind: NodeKind
    clearance_m: float
    branches: dict[int, Branch] = field(default_factory=dict)
    visits: list[tuple[int, int]] = field(default_factory=list)
    """(event sequence, stamp in ns) of every arrival identified as this node."""

    def ordered(self) -> list[Branch]:
        """Return the branches counter-clockwise from bearing -pi."""
        return sorted(self.branches.values(), key=lambda branch: (branch.bearing, branch.key))

    def slots(self) -> list[int]:
        """Return the keys of the branches that count, counter-clockwise: those given up have no place in the order."""
        return [branch.key for branch in self.ordered() if branch.edge is not None or not branch.given_up]

    def add_branch(self, bearing: float) -> Branch:
        """Add a branch seen for the first time."""
        key = max(self.branches, default=-1) + 1
        self.branches[key] = Branch(key, wrap(bearing))
        return self.branches[key]


class EdgeEnd(NamedTuple):
    """Where an edge meets a node; the end's frame has its origin at the node and x towards the other end."""

    node: int
    branch: int
    frame_in_node: UncertainPose


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """An edge with one stored edge-map, whose frame is that of ``ends[0]``."""

    id: int
    ends: tuple[EdgeEnd, EdgeEnd]
    terminal_x: float
    """Distance between its meet points (m) and its variance."""
    terminal_variance: float
    path_length_m: float
    traversals: tuple[int, ...]
    """The drives whose measurements its map holds, each used once."""

    def end_at(self, node: int, branch: int) -> int:
        """Return 0 or 1: the end at a node's branch."""
        return 0 if (self.ends[0].node, self.ends[0].branch) == (node, branch) else 1

    def across(self, end: int) -> UncertainPose:
        """Return the pose of the other end's node frame in this end's node frame."""
        here, there = self.ends[end], self.ends[1 - end]
        over = UncertainPose(SE2(self.terminal_x, 0.0, math.pi), np.diag([self.terminal_variance, 0.0, 0.0]))
        return here.frame_in_node @ over @ there.frame_in_node.inverse()


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A metric relation between two nodes that is no edge: a drive that passed nodes unnoticed or lost its way."""

    id: int
    from_node: int
    to_node: int
    to_in_from: UncertainPose
    path_length_m: float


class AtlasGraph:
    """Nodes, edges and links by id; ids are never used again."""

    def __init__(self) -> None:
        """Start empty."""
        self.nodes: dict[int, Node] = {}
        self.edges: dict[int, Edge] = {}
        self.links: dict[int, Link] = {}
        self.changed_nodes: set[int] = set()
        """Ids touched since the last save, also of what was removed."""
        self.changed_edges: set[int] = set()
        self.changed_links: set[int] = set()
        self._links_of: dict[int, set[int]] = {}
        self._next_node = self._next_edge = self._next_link = 0

    def next_ids(self) -> list[int]:
        """Return the ids the next node, edge and link will get."""
        return [self._next_node, self._next_edge, self._next_link]

    def resume(self, next_ids: list[int]) -> None:
        """Go on numbering after a graph has been read back; nothing counts as changed."""
        self._next_node, self._next_edge, self._next_link = next_ids
        self.changed_nodes.clear()
        self.changed_edges.clear()
        self.changed_links.clear()

    def add_node(self, kind: NodeKind, clearance_m: float, bearings: list[float]) -> Node:
        """Add a node with branches at ``bearings`` in its own frame (rad), keyed in that order."""
        node = Node(self._next_node, kind, clearance_m)
        self._next_node += 1
        for bearing in bearings:
            node.add_branch(bearing)
        self.nodes[node.id] = node
        self.changed_nodes.add(node.id)
        return node

    def remove_node(self, node_id: int) -> None:
        """Take out a node without edges, and its links."""
        for link_id in sorted(self._links_of.pop(node_id, set())):
            link = self.links.pop(link_id)
            self.changed_links.add(link_id)
            for other in (link.from_node, link.to_node):
                self._links_of.get(other, set()).discard(link_id)
        del self.nodes[node_id]
        self.changed_nodes.add(node_id)

    def connect(
        self,
        ends: tuple[EdgeEnd, EdgeEnd],
        terminal_x: float,
        terminal_variance: float,
        path_length_m: float,
        traversal: int,
    ) -> Edge:
        """Tie two free branches by a new edge."""
        edge = Edge(self._next_edge, ends, terminal_x, terminal_variance, path_length_m, (traversal,))
        self._next_edge += 1
        self.put_edge(edge)
        return edge

    def put_edge(self, edge: Edge) -> None:
        """Insert or replace an edge and occupy its branches."""
        self.edges[edge.id] = edge
        self.changed_edges.add(edge.id)
        for end in edge.ends:
            self.nodes[end.node].branches[end.branch].edge = edge.id
            self.changed_nodes.add(end.node)

    def remove_edge(self, edge_id: int) -> Edge:
        """Take an edge out and free its branches."""
        edge = self.edges.pop(edge_id)
        self.changed_edges.add(edge_id)
        for end in edge.ends:
            branch = self.nodes[end.node].branches[end.branch]
            if branch.edge == edge_id:
                branch.edge = None
            self.changed_nodes.add(end.node)
        return edge

    def add_link(self, from_node: int, to_node: int, to_in_from: UncertainPose, path_length_m: float) -> None:
        """Remember where two nodes lie relative to each other without an edge between them."""
        link = Link(self._next_link, from_node, to_node, to_in_from, path_length_m)
        self._next_link += 1
        self.put_link(link)

    def neighbours(self, node_id: int) -> Iterator[tuple[int, UncertainPose, float]]:
        """Yield (node, its pose in this node's frame, path length) over edges, then links, in order of id."""
        edge_ids = {b.edge for b in self.nodes[node_id].branches.values() if b.edge is not None}
        for edge_id in sorted(edge_ids):
            edge = self.edges[edge_id]
            for end in (0, 1):
                if edge.ends[end].node == node_id:
                    yield edge.ends[1 - end].node, edge.across(end), edge.path_length_m
        for link_id in sorted(self._links_of.get(node_id, ())):
            link = self.links[link_id]
            if link.from_node == node_id:
                yield link.to_node, link.to_in_from, link.path_length_m
            else:
                yield link.from_node, link.to_in_from.inverse(), link.path_length_m

    def absorb(self, gone: int, kept: int, gone_in_kept: UncertainPose, branches: dict[int, int]) -> None:
        """Make node ``gone`` part of ``kept``: its edges and links move over; ``branches`` maps its keys to kept's.

        Where both branches carry an edge, the caller has taken one out before.
        """
        node, target = self.nodes[gone], self.nodes[kept]
        for key, branch in node.branches.items():
            onto = target.branches[branches[key]]
            onto.seen += branch.seen
            onto.missed += branch.missed
            onto.attempts = max(onto.attempts, branch.attempts)
        for key, branch in target.branches.items():
            branch.missed += 0 if key in branches.values() else len(node.visits)
            branch.give_up_if_absent()
        for edge_id in sorted({b.edge for b in node.branches.values() if b.edge is not None}):
            edge = self.edges[edge_id]
            moved = tuple(
                EdgeEnd(kept, branches[end.branch], gone_in_kept @ end.frame_in_node) if end.node == gone else end
                for end in edge.ends
            )
            self.put_edge(replace(edge, ends=(moved[0], moved[1])))
        for link_id in sorted(self._links_of.pop(gone, set())):
            self._move_link(self.links.pop(link_id), gone, kept, gone_in_kept)
        target.visits = sorted(target.visits + node.visits)
        del self.nodes[gone]
        self.changed_nodes.update((gone, kept))

    def _move_link(self, link: Link, gone: int, kept: int, gone_in_kept: UncertainPose) -> None:
        """Re-hang a link's end or ends from one node onto another; one that would tie a node to itself goes."""
        self.changed_links.add(link.id)
        for node_id in (link.from_node, link.to_node):
            self._links_of.get(node_id, set()).discard(link.id)
        if link.from_node == gone:
            link = replace(link, from_node=kept, to_in_from=gone_in_kept @ link.to_in_from)
        if link.to_node == gone:
            link = replace(link, to_node=kept, to_in_from=link.to_in_from @ gone_in_kept.inverse())
        if link.from_node != link.to_node:
            self.put_link(link)

    def put_link(self, link: Link) -> None:
        """Insert or replace a link."""
        self.links[link.id] = link
        self.changed_links.add(link.id)
        self._links_of.setdefault(link.from_node, set()).add(link.id)
        self._links_of.setdefault(link.to_node, set()).add(link.id)
