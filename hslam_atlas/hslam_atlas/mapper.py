"""Build the graph from what happens: departures, arrivals, edge-maps, links."""

import math
from dataclasses import replace

from hslam_atlas.chain import chained
from hslam_atlas.graph import EdgeEnd, Node
from hslam_atlas.hypothesis import Hypothesis, Sight, best_constellation, is_where, learn_look_alikes, weigh
from hslam_atlas.look_alike_ways import learn_look_alike_ways
from hslam_atlas.merge import take_out
from hslam_atlas.part_joining import join_own_part
from hslam_atlas.questions import Questions
from hslam_atlas.retrace import compare, convinces, far_end, far_sight_in_node, update
from hslam_atlas.sighting import branch_towards, observe, open_question, sight_of, view_of
from hslam_atlas.state import AtlasState
from hslam_atlas.tie import Drive, Outcome, connect, is_refuted, link, tie
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_atlas.whereabouts import Here, Underway
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2


class Mapper:
    """Turns events, edge-maps and links into graph, maps and open questions."""

    def __init__(self, state: AtlasState, questions: Questions) -> None:
        """Start without knowing where the robot is."""
        self.state = state
        self.questions = questions
        self.here: Here | None = None
        self.underway: Underway | None = None
        self._lost_from: Underway | None = None
        self.visits = 0
        """Arrivals entered."""

    @property
    def knows_the_place(self) -> bool:
        """Whether the robot is at a node of the atlas, or on its way from one."""
        return self.here is not None or self.underway is not None

    def depart(self, event: GvgEvent, frame_link: FrameLink | None) -> None:
        """Note where a traversal starts: by the link from the last edge-map if there is one, else by the view."""
        view = view_of(event)
        here = self.here or self._arrive_unknown(event)
        node = self.state.graph.nodes[here.node]
        bearing = view.bearings_in_odom[event.branch]
        if frame_link is not None and here.edge_in_node is not None and frame_link.traversal == here.traversal:
            measured = UncertainPose(frame_link.departure_in_edge, frame_link.covariance)
            departure = here.edge_in_node @ measured
            key = branch_towards(node, departure.pose.theta, here.keys, event.branch, view)
        else:
            key = here.keys[event.branch]
            heading = node.branches[key].bearing
            first = all(branch.edge is None for branch in node.branches.values())
            spread = 0.0 if first else self.state.config.bearing_repeat
            departure = UncertainPose.diagonal(SE2(0.0, 0.0, heading), 0.0, spread)
        in_odom = SE2(view.x_in_odom, view.y_in_odom, bearing)
        odom_in_node = departure.pose @ in_odom.inverse()
        self.underway = Underway(node.id, key, event.sequence, departure, odom_in_node)
        self.here = None

    def lose(self) -> None:
        """Give up the traversal under way; where the robot is remains to be found out."""
        if self.underway is not None:
            branch = self.state.graph.nodes[self.underway.node].branches[self.underway.branch]
            branch.fail(self.state.config.attempts)
            self.state.graph.changed_nodes.add(self.underway.node)
            self._lost_from = self.underway
        self.underway = self.here = None

    def arrive(self, event: GvgEvent, edge_map: EdgeMap | None) -> None:
        """Identify the node arrived at and enter the drive."""
        underway, self.underway = self.underway, None
        if underway is None or edge_map is None:
            self._arrive_unknown(event)
            return
        turned = UncertainPose.diagonal(
            SE2(0.0, 0.0, -edge_map.departure_heading), 0.0, self.state.config.heading_floor
        )
        start = EdgeEnd(underway.node, underway.branch, underway.departure_in_node @ turned)
        sight = sight_of(event, edge_map)
        if self._never_left(start, edge_map, sight, event) or self._followed_known_edge(start, edge_map, sight, event):
            return
        hypotheses = self._hypotheses(start, edge_map, sight)
        if not self._identified(start, edge_map, sight, hypotheses, event):
            self._enter_new_node(start, edge_map, sight, hypotheses, event)
        self._drop_stranded()

    def _drop_stranded(self) -> None:
        """Forget nodes whose last edge was taken out: if they exist, an edge will lead there again."""
        for node_id in sorted(self.state.loosened & self.state.graph.nodes.keys()):
            edges = {branch.edge for branch in self.state.graph.nodes[node_id].branches.values()}
            if edges == {None} and (self.here is None or self.here.node != node_id):
                self.state.graph.remove_node(node_id)
                self.questions.forget(node_id)
        self.state.loosened.clear()

    def take_over(self, node: int, sight_in_node: UncertainPose, edge_map: EdgeMap, arrival: GvgEvent) -> None:
        """Be told where an arrival was by who has followed the robot meanwhile: nothing but the visit is entered.

        ``edge_map``: of what was seen on the way there, whole or not.
        """
        self.underway = self._lost_from = None
        self._stand(node, sight_of(arrival, edge_map), sight_in_node, edge_map, arrival)

    def join_parts(self) -> bool:
        """Join what was begun anew, where nobody knew the robot to be, to what it is a part of; return whether."""
        if self.here is None or not join_own_part(self.state, self.questions, self.here.node):
            return False
        self.follow_merges()
        return True

    def track(self, traversal: int, frame_in_node: UncertainPose) -> None:
        """Be told in which frame the robot is tracked at the node it stands at."""
        if self.here is not None:
            self.here = replace(self.here, traversal=traversal, edge_in_node=frame_in_node)

    def be_told(self, node: int) -> bool:
        """Take someone's word that this node is another one that it was suspected to be; False if that contradicts."""
        suspected = [q for q in self.questions.open if self.here is not None and q.node == self.here.node]
        question = next((q for q in suspected if q.other == node), None)
        if question is None or not self.questions.settle(self.state, question):
            return self.here is not None and self.here.node == node
        self.follow_merges()
        return True

    def _never_left(self, start: EdgeEnd, edge_map: EdgeMap, sight: Sight, event: GvgEvent) -> bool:
        """Recognise the node left from when the robot turned round within its free disc: no drive, no second node.

        The way within the disc alone proves nothing: walls unheard make the disc too large, and rooms lie side by side.
        The drive must also end where the node is, as well as its position repeats.
        """
        state = self.state
        node = state.graph.nodes[start.node]
        went_m = max(edge_map.path_length_m, abs(edge_map.terminal_x))
        expected = start.frame_in_node @ far_end(edge_map)
        if went_m > node.clearance_m or sight.kind is not node.kind or not is_where(node, expected, state.config):
            return False
        _, sight_in_node = best_constellation(state.graph, state.maps, node, sight, expected, state.config)
        node.branches[start.branch].fail(state.config.attempts)
        self._stand(node.id, sight, sight_in_node, edge_map, event)
        return True

    def _followed_known_edge(self, start: EdgeEnd, edge_map: EdgeMap, sight: Sight, event: GvgEvent) -> bool:
        """Verify a drive along a known edge by the whole edge-map, and update that."""
        edge_id = self.state.graph.nodes[start.node].branches[start.branch].edge
        if edge_id is None:
            return False
        edge = self.state.graph.edges[edge_id]
        end = edge.end_at(start.node, start.branch)
        match = compare(self.state, edge, end, edge_map, start.frame_in_node)
        if match is None or not convinces(match, edge, edge_map, self.state):
            return False
        sight_in_node = far_sight_in_node(edge, end, edge_map, match)
        there = edge.ends[1 - end].node
        update(self.state, edge, end, edge_map, match)
        self.state.graph.nodes[start.node].branches[start.branch].attempts = 0
        self._stand(there, sight, sight_in_node, edge_map, event)
        return True

    def _hypotheses(self, start: EdgeEnd, edge_map: EdgeMap, sight: Sight) -> list[Hypothesis]:
        """Weigh every node within the pose gate, best first."""
        state = self.state
        sight_in_start = start.frame_in_node @ far_end(edge_map)
        found: list[Hypothesis] = []
        places = [
            (state.graph.nodes[node_id], node_in_start.inverse() @ sight_in_start)
            for node_id, node_in_start in chained(state.graph, start.node).items()
        ]
        learn_look_alikes(state.graph, state.maps, places, sight, state.look_alikes, state.config)
        learn_look_alike_ways(state, start, edge_map)
        for node, sight_in_node in places:
            hypothesis = weigh(state.graph, state.maps, node, sight, sight_in_node, state.look_alikes, state.config)
            if hypothesis is not None:
                found.append(hypothesis)
        return sorted(found, key=lambda h: (-h.evidence, h.node))

    def _identified(
        self, start: EdgeEnd, edge_map: EdgeMap, sight: Sight, hypotheses: list[Hypothesis], event: GvgEvent
    ) -> bool:
        """Take the best hypothesis if it stands alone and nothing contradicts it."""
        config = self.state.config
        if not hypotheses:
            return False
        sure = [h for h in hypotheses if h.sure]
        best = (sure or hypotheses)[0]
        rivals = [h.evidence for h in hypotheses[1:] if not self.questions.likely_one(best.node, h.node)]
        lead = best.evidence - max(rivals, default=0.0)
        if not sure and (best.evidence < config.close_evidence or lead < config.close_margin or not best.credible):
            return False
        node = self.state.graph.nodes[best.node]
        if sight.come_along < 0:
            return False
        key = best.branches[sight.come_along]
        added = None
        if key is None:
            added = node.add_branch(sight.bearings[sight.come_along] + best.sight_in_node.pose.theta)
            added.seen, added.missed = 0, len(node.visits)  # this visit is counted where the robot stands
            key = added.key
        drive = Drive(start, EdgeEnd(node.id, key, best.sight_in_node), edge_map)
        outcome = tie(self.state, drive, sure=best.sure)
        beyond = config.close_evidence + config.close_margin
        if outcome is Outcome.CONTRADICTED and min(best.evidence, lead) >= beyond and best.map_evidence is not None:
            # Two drives that both passed one junction unnoticed and parted there contradict each other, not the node.
            outcome = tie(self.state, drive, sure=True)
        if outcome is Outcome.CONTRADICTED:
            if added is not None:
                del node.branches[added.key]
            return False
        if outcome is Outcome.CONNECTED:
            self.state.closures += 1
        start_node = next((merged.kept for merged in self.state.merged if merged.gone == start.node), start.node)
        there, sight_in_there = self._after_merges(best.node, best.sight_in_node)
        self._stand(there, sight, sight_in_there, edge_map, event)
        self._join_doubles(sure)
        self._review(start_node, there)
        return True

    def _join_doubles(self, sure: list[Hypothesis]) -> None:
        """Make one of all nodes that lie where this sight surely is."""
        for h in sure[1:]:
            if {sure[0].node, h.node} <= self.state.graph.nodes.keys():
                h_in_first = sure[0].sight_in_node @ h.sight_in_node.inverse()
                self.questions.join(self.state, h.node, sure[0].node, h_in_first)
        self.follow_merges()

    def _enter_new_node(
        self, start: EdgeEnd, edge_map: EdgeMap, sight: Sight, hypotheses: list[Hypothesis], event: GvgEvent
    ) -> None:
        """Add the node with the sight's frame as its own; the drive as an edge if its branch is free; the doubts."""
        state = self.state
        node = state.graph.add_node(sight.kind, sight.clearance_m, list(sight.bearings))
        stop = EdgeEnd(node.id, max(sight.come_along, 0), UncertainPose.exact(SE2()))
        drive = Drive(start, stop, edge_map)
        occupant = state.graph.nodes[start.node].branches[start.branch].edge
        passable = sight.kind is NodeKind.MEET_POINT  # a dead end is never passed unnoticed
        if occupant is not None and passable and is_refuted(state, occupant, start, edge_map):
            take_out(state, occupant)
            occupant = None
        if occupant is None and sight.come_along >= 0:
            connect(state, drive)
        else:
            link(state, drive)
        for h in hypotheses:
            if h.evidence > state.config.keep_evidence:
                self.questions.add(open_question(node.id, h))
        self._stand(node.id, sight, UncertainPose.exact(SE2()), edge_map, event, new=True)
        self._review(start.node, node.id)

    def _review(self, *touched: int) -> None:
        """Weigh what the new drive says about open questions; follow the merges that come of it."""
        self.questions.review(self.state, set(touched))
        self.follow_merges()

    def follow_merges(self) -> None:
        """If the node the robot stands at has become part of another, say where it stands in that one."""
        for merged in self.state.merged:
            if self.here is not None and merged.gone == self.here.node:
                frame = self.here.edge_in_node
                self.here = Here(
                    merged.kept,
                    tuple(merged.branches[key] for key in self.here.keys),
                    None if self.here.come is None else merged.branches[self.here.come],
                    self.here.traversal,
                    None if frame is None else merged.gone_in_kept @ frame,
                )
        self.state.merged.clear()

    def _after_merges(self, node: int, pose: UncertainPose) -> tuple[int, UncertainPose]:
        """Return what a node and a pose in it have become; the questions follow too."""
        for merged in self.state.merged:
            self.questions.follow(merged)
            if merged.gone == node:
                node, pose = merged.kept, merged.gone_in_kept @ pose
        self.state.merged.clear()
        return node, pose

    def _stand(
        self, node_id: int, sight: Sight, sight_in_node: UncertainPose, edge_map: EdgeMap, event: GvgEvent,
        *, new: bool = False,
    ) -> None:  # fmt: skip
        """Note where the robot is, and what the visit says of the node's branches."""
        self.visits += 1
        node = self.state.graph.nodes[node_id]
        keys = tuple(range(len(sight.bearings))) if new else observe(node, sight, sight_in_node.pose, self.state.config)
        node.visits.append((event.sequence, event.stamp_ns))
        self.state.graph.changed_nodes.add(node_id)
        edge_in_node = sight_in_node @ UncertainPose.exact(SE2(edge_map.terminal_x, 0.0, math.pi).inverse())
        come = keys[sight.come_along] if sight.come_along >= 0 else None
        self.here = Here(node_id, keys, come, edge_map.traversal, edge_in_node)

    def _arrive_unknown(self, event: GvgEvent) -> Here:
        """Stand at a node reached without an edge-map: new, for all that is known, at best linked by odometry."""
        view = view_of(event)
        node = self.state.graph.add_node(view.kind, view.clearance_m, list(view.bearings_in_odom))
        node.visits.append((event.sequence, event.stamp_ns))
        come = event.branch if event.kind is EventKind.ARRIVAL and event.branch >= 0 else None
        self.here = here = Here(node.id, tuple(range(view.degree)), come, -1, None)
        lost, self._lost_from = self._lost_from, None
        if lost is not None and lost.node in self.state.graph.nodes:
            pose = lost.odom_in_node @ SE2(view.x_in_odom, view.y_in_odom, 0.0)
            off = 0.3 + 2.0 * self.state.config.lost_per_metre * math.hypot(pose.x, pose.y)
            relation = UncertainPose.diagonal(pose, off, 0.1 + 0.05 * off)
            self.state.graph.add_link(lost.node, node.id, relation, math.hypot(pose.x, pose.y))
            self._doubt_unmapped(lost.node, node, view)
        return here

    def _doubt_unmapped(self, lost_from: int, node: Node, view: NodeView) -> None:
        """Ask whether a node reached without a map is one of those about."""
        state = self.state
        sight = Sight(view.kind, view.clearance_m, view.bearings_in_odom, -1, None)
        poses = chained(state.graph, lost_from)
        for other, other_in_start in poses.items():
            if other == node.id:
                continue
            sight_in_other = other_in_start.inverse() @ poses[node.id]
            h = weigh(
                state.graph,
                state.maps,
                state.graph.nodes[other],
                sight,
                sight_in_other,
                state.look_alikes,
                state.config,
            )
            if h is not None and h.evidence > state.config.keep_evidence:
                self.questions.add(open_question(node.id, h))
