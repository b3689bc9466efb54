"""Two atlases of one floor become one: of two sessions or two robots, with no common start."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import AtlasError
from hslam_atlas.graph import AtlasGraph, EdgeEnd
from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.part_joining import join_parts
from hslam_atlas.questions import Questions
from hslam_atlas.state import AtlasState
from hslam_atlas.store import AtlasStore


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


def merge_atlases(first: AtlasStore, second: AtlasStore, into: AtlasStore, config: AtlasConfig) -> MergedAtlases:
    """Write to ``into``, an empty atlas, what two others know; raises MergeRefusedError where they cannot be joined.

    Ids and numbers of drives of the first stay, those of the second follow after them.
    """
    state, questions, from_node = _side_by_side(first, second, into, config)
    graph = state.graph
    nodes, edges = len(graph.nodes), len(graph.edges)
    older, newer = ({n for n in graph.nodes if (n < from_node) is is_ours} for is_ours in (True, False))
    evidence, why = join_parts(state, questions, older, newer)
    if evidence is None:
        raise MergeRefusedError(f"not joined: {why}")
    closures = first.counts().get("closures", 0) + state.closures
    counts = first.counts() | state.look_alikes.counts | {"closures": closures}
    into.save(graph, questions.open, counts)
    return MergedAtlases(nodes - len(graph.nodes), edges - len(graph.edges), evidence)


def _side_by_side(
    first: AtlasStore, second: AtlasStore, into: AtlasStore, config: AtlasConfig
) -> tuple[AtlasState, Questions, int]:
    """Return both atlases as one of two parts, and the id its second part's nodes begin with."""
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
    alike = LookAlikes.from_counts(config.repetition, Counter(first.counts()) + Counter(second.counts()))
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
    return AtlasState(config, graph, into, alike), questions, node


def _numbers(graph: AtlasGraph, store: AtlasStore) -> Iterator[int]:
    """Yield the numbers of all events an atlas knows."""
    for node in graph.nodes.values():
        yield from (sequence for sequence, _ in node.visits)
    for edge in graph.edges.values():
        yield from edge.traversals
        yield store.get(edge.id).arrival
