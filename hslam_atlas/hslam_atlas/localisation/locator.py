"""The belief about where the robot is in an atlas: places, weighed by every drive; the atlas is not changed.

A robot that nobody has told where it is starts with no place at all.  Every arrival is matched with the whole atlas
until one place stands alone; from then on each drive is matched with the edge it should have followed, which notices
within one edge that the robot is elsewhere.
"""

import math
from dataclasses import replace

from hslam_atlas.chain import chained
from hslam_atlas.hypothesis import Sight, weigh
from hslam_atlas.localisation.anywhere import about_a_node, along_an_edge, arrived
from hslam_atlas.localisation.on_edge import base_on_edge
from hslam_atlas.localisation.place import ODOM, Place, beyond_doubt
from hslam_atlas.missions.mission import Happened, Sense
from hslam_atlas.retrace import compare, convinces, far_end, far_sight_in_node
from hslam_atlas.sighting import sight_of, view_of
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind
from hslam_types.se2 import SE2

MOST = 30.0
"""No belief is stronger (nats): a robot may be carried away."""
_KEPT = -3.0
"""Places with less evidence are dropped."""
_ODOM_STD_M, _ODOM_HEADING_STD = 0.15, math.radians(4.0)
"""Of a pose followed by odometry for the few metres off the graph."""


class Locator:
    """Takes cycle by cycle what happened, and knows what speaks for which place."""

    def __init__(self, state: AtlasState) -> None:
        """Begin lost."""
        self._state = state
        self.places: list[Place] = []
        self._last = Sense()
        self.arrived: tuple[GvgEvent, EdgeMap] | None = None
        """At a node: the last arrival and the map of the way that led to it, maybe from somewhere on an edge."""
        self.whole = True
        """Whether that way began at a node."""
        self.blocked: int | None = None
        """The edge that the last drive found blocked."""

    @property
    def certain(self) -> Place | None:
        """The place the robot is at, None while that is in doubt."""
        return beyond_doubt(self.places, self._state.config)

    def hear(self, happened: Happened) -> None:
        """Take one cycle."""
        for event in happened.events:
            self.arrived = None
            if event.kind is EventKind.DEPARTURE:
                link = next((link for link in happened.links if link.departure == event.sequence), None)
                self.places = [self._departed(place, event, link) for place in self.places]
            elif event.kind is EventKind.ARRIVAL:
                full = next((m for m in happened.edge_maps if m.arrival == event.sequence), None)
                self._arrive(event, full, happened.sense)
            elif event.kind is EventKind.LOST:
                self.leave(self._last)
            else:
                self._access(event, happened.sense)
        self._last = happened.sense

    def suppose(self, node: int, odom_in_node: SE2) -> None:
        """Be told about where the robot is, by odom in a node's frame; that is believed once a drive confirms it."""
        frame = UncertainPose.diagonal(odom_in_node, 0.5, math.radians(10.0))
        self.places = [Place(node, frame, ODOM, 0.5 * self._state.config.close_evidence)]

    def leave(self, sense: Sense) -> None:
        """Follow the robot by odometry from now on: it leaves the graph."""
        moved = [place.by_odometry(sense, _ODOM_STD_M, _ODOM_HEADING_STD) for place in self.places]
        self.places = [place for place in moved if place is not None]

    def correct(self, edge_id: int, end: int, sense: Sense) -> bool:
        """Match what is about the robot with an edge it is on, seen from ``end``; False where too little matches.

        The map so far may be some cycles old: what is corrected is the frame the robot is tracked in.
        """
        place, so_far = self.certain, sense.so_far(None)
        if place is None or so_far is None or so_far.traversal != place.traversal:
            return False
        base_in_frame = SE2(0.0, 0.0, -so_far.departure_heading) @ so_far.robot_at_arrival
        base_in_node = place.frame_in_node.pose @ base_in_frame
        edge = self._state.graph.edges[edge_id]
        if edge.ends[end].node != place.node:
            return False
        edge_in_node = edge.ends[end].frame_in_node.pose
        stored = self._state.maps.seen_from(edge_id, end)
        found = base_on_edge(stored, so_far, edge_in_node.inverse() @ base_in_node, self._state.config)
        if found is None:
            return False
        frame = edge_in_node @ found.pose @ base_in_frame.inverse()
        corrected = replace(place, frame_in_node=UncertainPose(frame, place.frame_in_node.covariance))
        self.places[self.places.index(place)] = corrected
        return True

    def _departed(self, place: Place, event: GvgEvent, link: FrameLink | None) -> Place:
        """Return a place after the departure by a branch in view."""
        view, config = view_of(event), self._state.config
        branch = place.keys[event.branch] if event.branch < len(place.keys) else None
        place_of_view = SE2(view.x_in_odom, view.y_in_odom, view.bearings_in_odom[event.branch])
        if link is not None and link.traversal == place.traversal:
            departure = place.frame_in_node @ UncertainPose(link.departure_in_edge, link.covariance)
        elif place.traversal == ODOM:
            departure = UncertainPose(place.frame_in_node.pose @ place_of_view, place.frame_in_node.covariance)
        elif (base_in_node := place.base_in_node(self._last)) is not None:
            odom_in_node = base_in_node @ self._last.base_in_odom.inverse()
            departure = UncertainPose.diagonal(
                odom_in_node @ place_of_view, config.origin_repeat_m, config.bearing_repeat
            )
        else:
            bearing = 0.0 if branch is None else self._state.graph.nodes[place.node].branches[branch].bearing
            departure = UncertainPose.diagonal(SE2(0.0, 0.0, bearing), 0.0, config.bearing_repeat)
        return replace(place, frame_in_node=departure, traversal=event.sequence, keys=(), come=-1, branch=branch)

    def _access(self, event: GvgEvent, sense: Sense) -> None:
        """Begin to track the robot from where it has reached the graph: the frame is its pose there."""
        self.leave(self._last)
        self.places = [
            replace(
                place,
                frame_in_node=UncertainPose(
                    place.frame_in_node.pose @ sense.base_in_odom, place.frame_in_node.covariance
                ),
                traversal=event.sequence,
            )
            for place in self.places
        ]

    def _arrive(self, event: GvgEvent, full: EdgeMap | None, sense: Sense) -> None:
        """Weigh every place by a drive's end, and every other of the atlas while none stands alone."""
        self.blocked = None
        edge_map = full if full is not None else sense.so_far(event)
        if edge_map is None:
            self.places = []
            return
        self.arrived, self.whole = (event, edge_map), full is not None
        sight = sight_of(event, edge_map)
        certain = self.certain
        found = [after for place in self.places for after in self._after(place, edge_map, sight)]
        if certain is not None and not found:
            found = self._stopped_short(certain, edge_map, sight)
        if beyond_doubt(found, self._state.config) is None:
            found += (along_an_edge if full is not None else about_a_node)(self._state, edge_map, sight)
        if full is None:  # the EKF level goes on in the frame of the access point
            turn = UncertainPose.exact(SE2(0.0, 0.0, edge_map.departure_heading))
            found = [replace(place, frame_in_node=place.frame_in_node @ turn) for place in found]
        self.places = _distinct(found)

    def _after(self, place: Place, edge_map: EdgeMap, sight: Sight) -> list[Place]:
        """Return where a drive has led from a place: along the edge of its branch, or by what the poses say."""
        state = self._state
        if place.traversal != edge_map.traversal:
            return []
        turned = UncertainPose.diagonal(SE2(0.0, 0.0, -edge_map.departure_heading), 0.0, state.config.heading_floor)
        start = place.frame_in_node @ turned
        edge_id = None if place.branch is None else state.graph.nodes[place.node].branches[place.branch].edge
        if edge_id is not None and place.branch is not None:
            edge = state.graph.edges[edge_id]
            end = edge.end_at(place.node, place.branch)
            match = compare(state, edge, end, edge_map, start)
            if match is not None and convinces(match, edge, edge_map, state):
                evidence = min(place.evidence + state.look_alikes.capped(match.evidence), MOST)
                there = edge.ends[1 - end].node
                return [arrived(state, there, sight, far_sight_in_node(edge, end, edge_map, match), edge_map, evidence)]
        return self._by_pose(place, start, edge_map, sight)

    def _by_pose(self, place: Place, start: UncertainPose, edge_map: EdgeMap, sight: Sight) -> list[Place]:
        """Return the nodes that lie where a drive has ended and look as its end does."""
        state, found = self._state, []
        end_in_start = start @ far_end(edge_map)
        for node_id, node_in_start in chained(state.graph, place.node).items():
            sight_in_node = node_in_start.inverse() @ end_in_start
            node = state.graph.nodes[node_id]
            h = weigh(state.graph, state.maps, node, sight, sight_in_node, state.look_alikes, state.config)
            if h is not None and h.credible and h.evidence > 0.0:
                evidence = min(place.evidence + h.evidence, MOST)
                at = arrived(state, node_id, sight, h.sight_in_node, edge_map, 0.0)
                found.append(replace(at, evidence=evidence))
        return found

    def _stopped_short(self, place: Place, edge_map: EdgeMap, sight: Sight) -> list[Place]:
        """Return the place on a known edge where the robot found its way blocked, if the map shows it there."""
        state = self._state
        if place.branch is None or sight.kind is not NodeKind.BOUNDARY_POINT:
            return []
        edge_id = state.graph.nodes[place.node].branches[place.branch].edge
        if edge_id is None or edge_map.path_length_m > state.graph.edges[edge_id].path_length_m:
            return []
        edge = state.graph.edges[edge_id]
        end = edge.end_at(place.node, place.branch)
        turned = SE2(0.0, 0.0, -edge_map.departure_heading)
        edge_in_node = edge.ends[end].frame_in_node.pose
        start = edge_in_node.inverse() @ place.frame_in_node.pose @ turned
        expected = start @ edge_map.robot_at_arrival
        found = base_on_edge(state.maps.seen_from(edge_id, end), edge_map, expected, state.config)
        if found is None:
            return []
        self.blocked = edge_id
        frame = edge_in_node @ found.pose @ edge_map.robot_at_arrival.inverse()
        spread = UncertainPose.diagonal(frame, _ODOM_STD_M, math.radians(2.0))
        return [Place(place.node, spread, edge_map.traversal, place.evidence)]


def _distinct(places: list[Place]) -> list[Place]:
    """Return the best of the places at each node and branch, best first, without those that are unlikely."""
    best: dict[tuple[int, int | None], Place] = {}
    for place in places:
        come = place.keys[place.come] if 0 <= place.come < len(place.keys) else None
        known = best.get((place.node, come))
        if place.evidence > _KEPT and (known is None or known.evidence < place.evidence):
            best[place.node, come] = place
    return sorted(best.values(), key=lambda place: (-place.evidence, place.node))
