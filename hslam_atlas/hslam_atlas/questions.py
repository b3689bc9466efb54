"""Open questions: nodes that may be one.  Kept and weighed until one answer stands alone."""

from dataclasses import dataclass, field, replace

from hslam_atlas.look_alikes import LookAlikes
from hslam_atlas.merge import branch_partners, merge, share_beginning, twin_match
from hslam_atlas.retrace import convinces
from hslam_atlas.state import AtlasState, Merged
from hslam_atlas.uncertain_pose import UncertainPose

_AGAINST = 4.0
"""What an edge that contradicts costs (nats): not all, for a node may have been passed unnoticed."""
_LIKELY = 4.0
"""Evidence (nats) beyond which two nodes are taken for likely one."""
_IMPOSSIBLE = 20.0
"""What a refused merge costs."""


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """Is ``node`` really ``other``?"""

    node: int
    other: int
    node_in_other: UncertainPose
    place_evidence: float
    """Log-odds by pose, kind, degree and clearance (nats)."""
    map_evidence: tuple[float, ...] = (0.0,)
    """What the match of landmarks about the node says (0 without one), then what each match of edges says; not capped
    (nats)."""
    compared: frozenset[tuple[int, int]] = field(default_factory=frozenset)
    """Pairs of edges that have been matched for it: none counts twice."""

    def evidence(self, look_alikes: LookAlikes) -> float:
        """Return the log-odds of "yes" (nats)."""
        return self.place_evidence + look_alikes.joint_by_ways(self.map_evidence[0], self.map_evidence[1:])


class Questions:
    """All open questions."""

    def __init__(self, look_alikes: LookAlikes) -> None:
        """Start without doubts; ``look_alikes`` says what matches are worth at any time."""
        self.open: list[Question] = []
        self._look_alikes = look_alikes

    def evidence(self, question: Question) -> float:
        """Return the log-odds of "yes" as of now (nats)."""
        return question.evidence(self._look_alikes)

    def of(self, node: int) -> list[Question]:
        """Return the questions about a node, the likeliest answer first."""
        return sorted((q for q in self.open if q.node == node), key=lambda q: (-self.evidence(q), q.other))

    def likely_one(self, a: int, b: int) -> bool:
        """Whether two nodes are likely one themselves, and so no rivals as answers to a question."""
        return any({q.node, q.other} == {a, b} and self.evidence(q) > _LIKELY for q in self.open)

    def add(self, question: Question) -> None:
        """Open a question."""
        self.open.append(question)

    def forget(self, node: int) -> None:
        """Drop the questions about a node that is no more."""
        self.open = [q for q in self.open if node not in {q.node, q.other}]

    def review(self, state: AtlasState, touched: set[int]) -> None:
        """Weigh new edges of the touched nodes for every question they bear on; close what stands alone."""
        asked = [q for q in self.open if q.node in touched or q.other in touched]
        for question in asked:
            if question in self.open:
                self.open[self.open.index(question)] = _weighed(state, question)
        self._drop_unlikely(state)
        while (answer := self._stands_alone(state)) is not None:
            if not self.settle(state, answer):
                self.open[self.open.index(answer)] = replace(answer, place_evidence=answer.place_evidence - _IMPOSSIBLE)
        self._drop_unlikely(state)

    def _drop_unlikely(self, state: AtlasState) -> None:
        self.open = [q for q in self.open if self.evidence(q) > state.config.keep_evidence]

    def settle(self, state: AtlasState, answer: Question) -> bool:
        """Make the two nodes one; False, and nothing changed, if that contradicts the maps."""
        return self._merge(state, answer.node, answer.other, answer.node_in_other, sure=False)

    def join(self, state: AtlasState, node: int, other: int, node_in_other: UncertainPose) -> bool:
        """Make two nodes one that are so beyond doubt; False only where one kind of node cannot be the other."""
        return self._merge(state, node, other, node_in_other, sure=True)

    def _merge(self, state: AtlasState, node: int, other: int, node_in_other: UncertainPose, *, sure: bool) -> bool:
        count = len(state.merged)
        if not merge(state, node, other, node_in_other, sure=sure):
            return False
        for merged in state.merged[count:]:
            self.follow(merged)
        return True

    def follow(self, merged: Merged) -> None:
        """Rewrite the questions after a merge; one about a single node is answered."""
        kept: dict[tuple[int, int], Question] = {}
        for question in self.open:
            q = _followed(question, merged)
            known = kept.get((q.node, q.other))
            if q.node != q.other and (known is None or self.evidence(known) < self.evidence(q)):
                kept[q.node, q.other] = q
        self.open = list(kept.values())

    def _stands_alone(self, state: AtlasState) -> Question | None:
        """Return a question whose answer is beyond doubt: enough evidence and a clear lead over every rival."""
        for q in sorted(self.open, key=lambda q: (-self.evidence(q), q.node, q.other)):
            evidence = self.evidence(q)
            if evidence < state.config.close_evidence:
                return None
            others = [r for r in self.open if r is not q and r.node == q.node]
            rivals = [self.evidence(r) for r in others if not self.likely_one(q.other, r.other)]
            if evidence - max(rivals, default=0.0) >= state.config.close_margin:
                return q
        return None


def _followed(question: Question, merged: Merged) -> Question:
    """Return the question as it reads after a merge, the younger node asked about."""
    node, other, pose = question.node, question.other, question.node_in_other
    if node == merged.gone:
        node, pose = merged.kept, pose @ merged.gone_in_kept.inverse()
    if other == merged.gone:
        other, pose = merged.kept, merged.gone_in_kept @ pose
    if node < other:
        node, other, pose = other, node, pose.inverse()
    return replace(question, node=node, other=other, node_in_other=pose)


def _weighed(state: AtlasState, question: Question) -> Question:
    """Match the edges that must be one if the nodes are, as far as that is not done yet."""
    graph = state.graph
    node, other = graph.nodes[question.node], graph.nodes[question.other]
    partners = branch_partners(node, other, question.node_in_other, state.config.branch_gate)
    place, map_evidence, compared = question.place_evidence, list(question.map_evidence), set(question.compared)
    for key, onto in partners.items():
        edge_id = node.branches[key].edge
        other_id = None if onto is None else other.branches[onto].edge
        if edge_id is None or other_id is None or onto is None or edge_id == other_id:
            continue
        if (edge_id, other_id) in compared:
            continue
        compared.add((edge_id, other_id))
        edge, known = graph.edges[edge_id], graph.edges[other_id]
        end, known_end = edge.end_at(node.id, key), known.end_at(other.id, onto)
        match = twin_match(state, edge_id, end, other_id, known_end, question.node_in_other)
        if match is not None and convinces(match, known, state.maps.get(edge_id), state):
            map_evidence.append(match.evidence)
        elif match is not None or not share_beginning(state, edge_id, end, other_id, known_end, question.node_in_other):
            place -= _AGAINST
    return replace(question, place_evidence=place, map_evidence=tuple(map_evidence), compared=frozenset(compared))
