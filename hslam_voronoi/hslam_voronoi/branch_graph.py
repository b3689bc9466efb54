"""A planar multigraph of branches that can lose spurs and merge nodes: the reduction works on it.

Nodes carry position and clearance; a branch carries its path with the clearance along it.  Every node
keeps its branch ends in counter-clockwise order, and every operation keeps that order, so that the
planar embedding survives merges (directions would not: merged branches share their first metres).
Numbers are handed out in order, so that every operation is deterministic.
"""

import functools
import math
from dataclasses import dataclass, field

import numpy as np

from hslam_types.se2 import Array

End = tuple[int, int]
"""A branch's number, and 0 for where it begins or 1 for where it ends."""


@dataclass(eq=False)
class Branch:
    """One edge; ``path`` is k x 3 (x, y, clearance) from node ``u`` to node ``v``."""

    u: int
    v: int
    path: Array
    length: float

    def path_from(self, end: int) -> Array:
        """Return the path as walked from end 0 or 1."""
        return self.path if end == 0 else self.path[::-1]

    def node(self, end: int) -> int:
        """Return the node at end 0 or 1."""
        return self.u if end == 0 else self.v


@dataclass(eq=False)
class Hub:
    """One node: where it is, its clearance, and what was merged into it."""

    x: float
    y: float
    clearance: float
    members: list[tuple[float, float]] = field(default_factory=list)
    ends: list[End] = field(default_factory=list)
    """The branch ends that meet here, counter-clockwise; a loop has two."""


class BranchGraph:
    """The graph under reduction."""

    def __init__(self) -> None:
        """Begin empty."""
        self.hubs: dict[int, Hub] = {}
        self.branches: dict[int, Branch] = {}
        self._next_branch = 0

    def add_hub(self, number: int, x: float, y: float, clearance: float) -> None:
        """Add a node without branches."""
        self.hubs[number] = Hub(x, y, clearance, [(x, y)])

    def add_branch(self, u: int, v: int, path: Array) -> None:
        """Add an edge along ``path`` (k x 3); call `order_ends` when all are there."""
        number = self._number(u, v, path)
        self.hubs[u].ends.append((number, 0))
        self.hubs[v].ends.append((number, 1))

    def order_ends(self) -> None:
        """Sort the ends at every node counter-clockwise by the direction of their first step."""
        for hub in self.hubs.values():
            hub.ends.sort(key=functools.partial(self._first_direction, hub))

    def remove_branch(self, number: int) -> None:
        """Take an edge out; a node left without any goes with it."""
        branch = self.branches.pop(number)
        for end in (0, 1):
            self.hubs[branch.node(end)].ends.remove((number, end))
        for node in {branch.u, branch.v}:
            if not self.hubs[node].ends:
                del self.hubs[node]

    def degree(self, number: int) -> int:
        """Return how many branch ends meet in a node."""
        return len(self.hubs[number].ends)

    def collapse(self) -> None:
        """Join the two branches of every node of degree two; a lone loop's stays."""
        for number in list(self.hubs):
            ends = self.hubs[number].ends
            if len(ends) != 2 or ends[0][0] == ends[1][0]:
                continue
            (first, a), (second, b) = ends
            before, after = self.branches.pop(first), self.branches.pop(second)
            path = np.concatenate([before.path_from(a)[::-1], after.path_from(b)[1:]])
            u, v = before.node(1 - a), after.node(1 - b)
            joined = self._number(u, v, path)
            self._substitute(u, (first, 1 - a), [(joined, 0)])
            self._substitute(v, (second, 1 - b), [(joined, 1)])
            del self.hubs[number]

    def contract(self, number: int) -> int:
        """Merge the two nodes of a branch into the one with the larger clearance; return that one."""
        branch = self.branches[number]
        end = 1 if self.hubs[branch.v].clearance > self.hubs[branch.u].clearance else 0
        keep, gone = branch.node(end), branch.node(1 - end)
        bridge = branch.path_from(end)
        # What left the vanished node, from the bridge onwards, takes the bridge's place in the order.
        ends = self.hubs[gone].ends
        at = ends.index((number, 1 - end))
        self._substitute(keep, (number, end), ends[at + 1 :] + ends[:at])
        self.hubs[keep].members.extend(self.hubs[gone].members)
        del self.branches[number], self.hubs[gone]
        for moved, side in ends:
            if moved != number:
                self._reroute(moved, side, keep, bridge)
        return keep

    def _number(self, u: int, v: int, path: Array) -> int:
        self.branches[self._next_branch] = Branch(u, v, path, _length(path))
        self._next_branch += 1
        return self._next_branch - 1

    def _reroute(self, number: int, side: int, keep: int, bridge: Array) -> None:
        """Let a branch begin (side 0) or end (1) in ``keep``, by way of ``bridge`` (from keep to its old node)."""
        branch = self.branches[number]
        if side == 0:
            branch.u, branch.path = keep, np.concatenate([bridge, branch.path[1:]])
        else:
            branch.v, branch.path = keep, np.concatenate([branch.path[:-1], bridge[::-1]])
        branch.length = _length(branch.path)

    def _substitute(self, node: int, old: End, new: list[End]) -> None:
        ends = self.hubs[node].ends
        at = ends.index(old)
        ends[at : at + 1] = new

    def _first_direction(self, hub: Hub, end: End) -> tuple[float, End]:
        path = self.branches[end[0]].path_from(end[1])
        apart = np.flatnonzero((path[:, 0] != hub.x) | (path[:, 1] != hub.y))
        at = path[apart[0]] if len(apart) else path[0]
        return math.atan2(float(at[1]) - hub.y, float(at[0]) - hub.x), end


def _length(path: Array) -> float:
    steps = np.diff(path[:, :2], axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
