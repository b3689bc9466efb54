"""Two parts of an atlas that no edge or link connects become one, where they show one floor.

Every edge of one is matched with every edge of the other, by whole edge-maps, as a known edge is verified.  Each match
is thought through to its end (`merge`): the nodes at its ends are one, then so are the edges on their common branches.
What all the edges that come together say is the evidence of that way to lay one part on the other.  The best way must
have enough of it and a clear lead over every way that contradicts it; else nothing is joined.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from hslam_atlas.chain import chained
from hslam_atlas.config import AtlasConfig
from hslam_atlas.graph import Edge
from hslam_atlas.merge import Consequence, consequence
from hslam_atlas.questions import Question, Questions
from hslam_atlas.retrace import compare
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose

_LEAST_M = 3.0
"""The frame of a shorter edge has no direction of its own that two drives share."""


def join_own_part(state: AtlasState, questions: Questions, node: int) -> bool:
    """Join the part that a node is in to every other that it fits beyond doubt; return whether any was."""
    own = set(chained(state.graph, node))
    others = state.graph.nodes.keys() - own
    joined = False
    while others:
        part = set(chained(state.graph, min(others)))
        others -= part
        evidence, _ = join_parts(state, questions, part, own)
        joined |= evidence is not None
    return joined


def join_parts(state: AtlasState, questions: Questions, older: set[int], newer: set[int]) -> tuple[float | None, str]:
    """Join two parts, given by their nodes; return the evidence (nats), None and why not where that cannot be."""
    evidence: float | None = None
    while True:
        ways = sorted(_ways(state, older, newer), key=lambda way: -way.evidence)
        best = ways[0] if ways else None
        why = _doubt(best, ways, state.config)
        if best is None or why:
            return evidence, why
        answer = Question(best.gone, best.kept, best.gone_in_kept, best.evidence)
        if not questions.settle(state, answer):
            return evidence, "the best way to lay one on the other contradicts itself"
        evidence = best.evidence if evidence is None else evidence


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """A way to lay one part on the other: nodes of one match, and the edges that are one by it."""

    gone: int
    kept: int
    gone_in_kept: UncertainPose
    pairs: frozenset[tuple[int, int]]
    """The edges that become one by it, the one gone first."""
    evidence: float

    def contradicts(self, other: "_Way") -> bool:
        """Whether both cannot be true: an edge would be two edges."""
        return any((a == c) != (b == d) for a, b in self.pairs for c, d in other.pairs) or not self.pairs & other.pairs


def _doubt(best: _Way | None, ways: list[_Way], config: AtlasConfig) -> str:
    """Return why the best way cannot be taken, empty if it can."""
    if best is None:
        return "no edge of one looks like an edge of the other"
    if best.evidence < config.close_evidence:
        return (
            f"the best way to lay one on the other makes {len(best.pairs)} edges one, which speaks for it by "
            f"{best.evidence:.1f} nats of the {config.close_evidence:g} that are asked for"
        )
    rival = max((way.evidence for way in ways if way.contradicts(best)), default=0.0)
    if best.evidence - rival < config.close_margin:
        return f"they fit in more than one way ({best.evidence:.1f} and {rival:.1f} nats)"
    return ""


def _ways(state: AtlasState, older: set[int], newer: set[int]) -> Iterator[_Way]:
    """Yield every way that two edges, one of each part, give rise to and that does not contradict itself."""
    ours = [edge for edge in state.graph.edges.values() if edge.ends[0].node in older]
    theirs = [edge for edge in state.graph.edges.values() if edge.ends[0].node in newer]
    matches: dict[frozenset[int], float] = {}
    starts = list(_starts(state, ours, theirs, matches))
    prior = -math.log(max(2 * len(ours) * len(theirs), 1))
    known: list[Consequence] = []
    for pair, gone, kept, gone_in_kept in starts:
        if any((gone, kept) in way.nodes and pair in map(frozenset, way.edges) for way in known):
            continue  # the same way, begun from another of its edges
        found = consequence(state, gone, kept, gone_in_kept)
        if found is not None and found.edges:
            known.append(found)
            said = state.look_alikes.joint(matches[one] for one in map(frozenset, found.edges) if one in matches)
            yield _Way(gone, kept, gone_in_kept, found.edges, prior + said)


def _starts(
    state: AtlasState, ours: list[Edge], theirs: list[Edge], matches: dict[frozenset[int], float]
) -> Iterator[tuple[frozenset[int], int, int, UncertainPose]]:
    """Yield each pair of edges whose maps agree, with two nodes that are one by it, the younger first.

    ``matches`` takes the evidence of each pair.
    """
    for edge, other, end in product(ours, theirs, (0, 1)):
        if min(edge.terminal_x, other.terminal_x) < _LEAST_M:
            continue
        here, there = edge.ends[0], other.ends[end]
        match = compare(state, edge, 0, state.maps.seen_from(other.id, end), there.frame_in_node)
        if match is None or not match.agrees:
            continue
        pair = frozenset((edge.id, other.id))
        matches[pair] = max(match.evidence, matches.get(pair, -math.inf))
        offset = UncertainPose(match.alignment.offset, match.alignment.offset_covariance)
        there_in_here = here.frame_in_node @ offset @ there.frame_in_node.inverse()
        if there.node > here.node:
            yield pair, there.node, here.node, there_in_here
        elif there.node < here.node:
            yield pair, here.node, there.node, there_in_here.inverse()
