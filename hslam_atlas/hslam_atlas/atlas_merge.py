"""Two atlases of one floor become one: of two sessions or two robots, with no common start.

Every edge of one is matched with every edge of the other, by whole edge-maps, as a known edge is verified.  Each match
is thought through to its end (`merge`): the nodes at its ends are one, then so are the edges on their common branches.
What all the edges that come together say is the evidence of that way to lay one atlas on the other.  The best way must
have enough of it and a clear lead over every way that contradicts it; else nothing is joined.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import AtlasError
from hslam_atlas.graph import AtlasGraph, EdgeEnd
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.merge import Consequence, consequence
from hslam_atlas.questions import Question, Questions
from hslam_atlas.retrace import compare
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore
from hslam_atlas.uncertain_pose import UncertainPose

_LEAST_M = 3.0
"""The frame of a shorter edge has no direction of its own that two drives share."""


class MergeRefusedError(AtlasError):
    """Two atlases cannot be joined beyond doubt; the text says why."""


@dataclass(frozen=True)
class MergedAtlases:
    """What joining has brought together."""

    nodes: int
    """Of both that are one now."""
    edges: int
    """Likewise."""
    evidence: float
    """For the first way they were laid on each other (nats)."""


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """A way to lay the second atlas on the first: nodes of one match, and the edges that are one by it."""

    gone: int
    kept: int
    gone_in_kept: UncertainPose
    pairs: frozenset[tuple[int, int]]
    """(edge of the second atlas, edge of the first)."""
    evidence: float

    def contradicts(self, other: "_Way") -> bool:
        """Whether both cannot be true: an edge would be two edges."""
        return any((a == c) != (b == d) for a, b in self.pairs for c, d in other.pairs) or not self.pairs & other.pairs


def merge_atlases(first: AtlasStore, second: AtlasStore, into: AtlasStore, config: AtlasConfig) -> MergedAtlases:
    """Write to ``into``, an empty atlas, what two others know; raises MergeRefusedError where they cannot be joined.

    Ids and numbers of drives of the first stay, those of the second follow after them.
    """
    state, questions, from_node, from_edge = _side_by_side(first, second, into, config)
    graph = state.graph
    nodes, edges = len(graph.nodes), len(graph.edges)
    evidence: float | None = None
    while True:
        ways = sorted(_ways(state, from_node, from_edge), key=lambda way: -way.evidence)
        best = ways[0] if ways else None
        why = _doubt(best, ways, config)
        if best is None or why:
            break
        answer = Question(best.gone, best.kept, best.gone_in_kept, best.evidence)
        if not questions.settle(state, answer):
            why = "the best way to lay one on the other contradicts itself"
            break
        evidence = best.evidence if evidence is None else evidence
    if evidence is None:
        raise MergeRefusedError(f"not joined: {why}")
    counts = {"closures": 0, "compared": state.look_alikes.compared, "alike": state.look_alikes.alike}
    counts = first.counts() | counts | {"closures": first.counts().get("closures", 0) + state.closures}
    into.save(graph, questions.open, counts)
    return MergedAtlases(nodes - len(graph.nodes), edges - len(graph.edges), evidence)


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


def _ways(state: AtlasState, from_node: int, from_edge: int) -> Iterator[_Way]:
    """Yield every way that two edges, one of each atlas, give rise to and that does not contradict itself."""
    graph = state.graph
    ours = [edge for edge in graph.edges.values() if edge.id < from_edge]
    theirs = [edge for edge in graph.edges.values() if edge.id >= from_edge]
    matches: dict[tuple[int, int], float] = {}
    starts: list[tuple[tuple[int, int], int, int, UncertainPose]] = []
    for edge in ours:
        for other in theirs:
            for end in (0, 1):
                if min(edge.terminal_x, other.terminal_x) < _LEAST_M:
                    continue
                here, there = edge.ends[0], other.ends[end]
                match = compare(state, edge, 0, state.maps.seen_from(other.id, end), there.frame_in_node)
                if match is None or not match.agrees:
                    continue
                offset = UncertainPose(match.alignment.offset, match.alignment.offset_covariance)
                there_in_here = here.frame_in_node @ offset @ there.frame_in_node.inverse()
                matches[other.id, edge.id] = max(match.evidence, matches.get((other.id, edge.id), -math.inf))
                if there.node != here.node and there.node >= from_node > here.node:
                    starts.append(((other.id, edge.id), there.node, here.node, there_in_here))
    prior = -math.log(max(2 * len(ours) * len(theirs), 1))
    known: list[Consequence] = []
    for pair, gone, kept, gone_in_kept in starts:
        if any((gone, kept) in way.nodes and pair in way.edges for way in known):
            continue  # the same way, begun from another of its edges
        found = consequence(state, gone, kept, gone_in_kept)
        if found is not None and found.edges:
            known.append(found)
            said = state.look_alikes.joint(matches[one] for one in found.edges if one in matches)
            yield _Way(gone, kept, gone_in_kept, found.edges, prior + said)


def _side_by_side(
    first: AtlasStore, second: AtlasStore, into: AtlasStore, config: AtlasConfig
) -> tuple[AtlasState, Questions, int, int]:
    """Return both atlases as one of two parts, and the ids its second part's nodes and edges begin with."""
    graph, open_questions = first.load()
    other, other_questions = second.load()
    node, edge, link = graph.next_ids()
    drive = 1 + max(_numbers(graph, first), default=-1)
    for edge_id in graph.edges:
        into.put(edge_id, first.get(edge_id))
    for stored in other.nodes.values():
        stored.id += node
        stored.visits = [(sequence + drive, stamp_ns) for sequence, stamp_ns in stored.visits]
        for branch in stored.branches.values():
            branch.edge = None if branch.edge is None else branch.edge + edge
        graph.nodes[stored.id] = stored
    for known in other.edges.values():
        ends = tuple(EdgeEnd(end.node + node, end.branch, end.frame_in_node) for end in known.ends)
        drives = tuple(number + drive for number in known.traversals)
        graph.put_edge(replace(known, id=known.id + edge, ends=(ends[0], ends[1]), traversals=drives))
        edge_map = second.get(known.id)
        numbered = replace(edge_map, traversal=edge_map.traversal + drive, arrival=edge_map.arrival + drive)
        into.put(known.id + edge, numbered)
    for tie in other.links.values():
        graph.put_link(replace(tie, id=tie.id + link, from_node=tie.from_node + node, to_node=tie.to_node + node))
    follow = [have + their for have, their in zip(graph.next_ids(), other.next_ids(), strict=True)]
    graph.resume(follow)
    graph.changed_nodes.update(graph.nodes)
    graph.changed_edges.update(graph.edges)
    graph.changed_links.update(graph.links)
    counts = [store.counts() for store in (first, second)]
    alike = LookAlikes(
        config.repetition, sum(c.get("compared", 0) for c in counts), sum(c.get("alike", 0) for c in counts)
    )
    questions = Questions(alike)
    questions.open = open_questions + [
        replace(
            question,
            node=question.node + node,
            other=question.other + node,
            compared=frozenset((a + edge, b + edge) for a, b in question.compared),
        )
        for question in other_questions
    ]
    return AtlasState(config, graph, into, alike), questions, node, edge


def _numbers(graph: AtlasGraph, store: AtlasStore) -> Iterator[int]:
    """Yield the numbers of all events an atlas knows."""
    for node in graph.nodes.values():
        yield from (sequence for sequence, _ in node.visits)
    for edge in graph.edges.values():
        yield from edge.traversals
        yield store.get(edge.id).arrival
