"""What the robot is out for, and who follows it meanwhile: the mapper, or a locator that changes nothing."""

import math

from hslam_atlas.localisation.handover import locator_from, take_over
from hslam_atlas.localisation.locator import Locator
from hslam_atlas.localisation.place import ODOM
from hslam_atlas.mapper import Mapper
from hslam_atlas.missions.destination import AtNode, Destination, DestinationError, check
from hslam_atlas.missions.explore import Explore
from hslam_atlas.missions.in_turn import InTurn
from hslam_atlas.missions.localise import Localise
from hslam_atlas.missions.mission import Decision, Happened, Mission, Sense
from hslam_atlas.missions.navigate import Navigate
from hslam_atlas.numbering import Numbering
from hslam_atlas.picture import node_poses
from hslam_atlas.questions import Questions
from hslam_atlas.state import AtlasState
from hslam_types.gvg_events import EventKind, GvgEvent
from hslam_types.se2 import SE2


class Dispatch:
    """Takes up one mission in place of another, in the middle of whatever the robot does."""

    def __init__(self, state: AtlasState, questions: Questions, mapper: Mapper, numbering: Numbering) -> None:
        """Begin without a mission; a robot in an atlas taken up has to be found before anything is mapped."""
        self._state, self._questions, self._mapper, self._numbering = state, questions, mapper, numbering
        self.mission: Mission | None = None
        self.of_itself = True
        """Whether the mission is the configuration's, not somebody's wish."""
        self.locator: Locator | None = None
        """Who follows the robot while the atlas is only used; None while the mapper does."""
        self.return_home = state.config.return_home
        """Whether to go back to the oldest node after exploring."""
        self._at: GvgEvent | None = None
        """The arrival at the node the robot stands at."""
        self._driving = self._stopped = False
        self._sense = Sense()
        self.path_length_m = 0.0
        """Driven, by odometry."""

    @property
    def now(self) -> Mission | None:
        """The mission under way, of several in turn the present one."""
        return self.mission.now if isinstance(self.mission, InTurn) else self.mission

    @property
    def doing(self) -> str:
        """What the robot is about, in one word."""
        if self.mission is not None:
            return self.mission.doing
        if self._stopped:
            return "stopping" if self._driving else "stopped"
        return "mapping" if self.locator is None else "following"

    @property
    def exploring(self) -> bool:
        """Whether the mission is to explore, maybe once the robot is found."""
        return isinstance(self.mission, InTurn | Explore)

    def begin(self, mission: str) -> None:
        """Take up a mission of the configuration."""
        self.mission, self._stopped, self.of_itself = None, False, True
        if mission != "none" and self._state.graph.nodes and not self._mapper.knows_the_place:
            self.locator = self.locator or Locator(self._state)
        if mission == "explore":
            self.mission = self._find_and_explore()
        elif mission == "localise":
            self.mission = self._search(self._follow())

    def explore(self) -> None:
        """Take up the mission to explore, from the next step on; no news where that is the mission already."""
        if not self.exploring:
            self.mission, self.of_itself = self._find_and_explore(), False

    def localise(self, *, anew: bool) -> None:
        """Take up the mission to find the robot; ``anew``: where it was thought to be is forgotten."""
        locator = self._follow()
        if anew:
            locator.places = []
        self.mission, self.of_itself = self._search(locator), False

    def navigate(self, destination: Destination) -> None:
        """Go somewhere, in place of what was to be done; raises DestinationError where there is no such place."""
        check(destination, self._state.graph)
        if not isinstance(self.mission, Navigate):
            self.mission = self._to(self._follow())
        self.mission.go_to(destination)
        self.of_itself = False

    def hint(self, base_in_map: SE2) -> None:
        """Be told about where the robot is; that is believed once a drive confirms it.

        Raises DestinationError where `map` shows nothing.
        """
        poses = node_poses(self._state.graph)
        if not poses:
            raise DestinationError("the atlas is empty: it has no place the robot could be at")
        node = min(poses, key=lambda n: math.dist(poses[n][:2], base_in_map[:2]))
        exploring, locator = self.exploring, self._follow()
        locator.suppose(node, poses[node].to(base_in_map) @ self._sense.base_in_odom.inverse())
        if exploring:
            self.mission = self._find_and_explore()

    def stop(self) -> None:
        """Give up the mission; the traversal under way is driven to its end."""
        self.mission, self._stopped = None, True

    def refused(self) -> None:
        """Be told that the GVG level did not take the goal: the robot is not where it was thought to be."""
        self._mapper.here = self._at = None
        if self.mission is not None:
            self.mission.refused()

    def lose(self) -> None:
        """Be told that what is under way will not be announced to its end: where the robot is has to show."""
        self._mapper.lose()
        self._numbering.renew()
        self._driving = False
        if self.locator is not None:
            self.locator.places = []
        self.refused()

    def step(self, happened: Happened) -> Decision:
        """Take one cycle, which the mapper has entered if it follows the robot."""
        self.path_length_m += math.dist(self._sense.base_in_odom[:2], happened.sense.base_in_odom[:2])
        self._sense = happened.sense
        for event in happened.events:
            self._at = event if event.kind is EventKind.ARRIVAL else None
            self._driving = event.kind in (EventKind.ACCESS, EventKind.DEPARTURE)
        if self.mission is not None:
            return self.mission.step(happened)
        if self.locator is not None:
            self.locator.hear(happened)
        return Decision()

    def tracked(self) -> tuple[int, int, SE2] | None:
        """Return the traversal whose frame the robot is tracked in, a node, and that frame in the node's.

        None while nobody knows.  Until its arrival that is the departure frame, from then on the frame of its edge-map,
        as at the EKF level.
        """
        if self.locator is not None:
            place = self.locator.certain
            known = place is not None and place.traversal != ODOM
            return (place.traversal, place.node, place.frame_in_node.pose) if place is not None and known else None
        here, underway = self._mapper.here, self._mapper.underway
        if underway is not None:
            return self._numbering.said(underway.sequence), underway.node, underway.departure_in_node.pose
        if here is not None and here.edge_in_node is not None:
            return self._numbering.said(here.traversal), here.node, here.edge_in_node.pose
        return None

    def base_in_map(self) -> SE2 | None:
        """Return where the robot is in the composed picture, None while that is in doubt or not in it."""
        node, sense = self.about(), self._sense
        poses = {} if node is None else node_poses(self._state.graph)
        if node is None or node not in poses:
            return None
        if self.locator is not None:
            place = self.locator.certain
            base_in_node = None if place is None else place.base_in_node(sense)
        else:
            tracked = self.tracked()
            known = tracked is not None and tracked[0] == sense.traversal and sense.base_in_frame is not None
            base_in_node = tracked[2] @ sense.base_in_frame if tracked and known and sense.base_in_frame else None
        return None if base_in_node is None else poses[node] @ base_in_node

    def about(self) -> int | None:
        """Return the node the robot is at or was last at, None while that is in doubt."""
        if self.locator is not None:
            place = self.locator.certain
            return None if place is None else place.node
        at = self._mapper.underway or self._mapper.here
        return None if at is None else at.node

    def _follow(self) -> Locator:
        """Return the locator, who follows the robot from now on."""
        if self.locator is None:
            self.locator = locator_from(self._mapper, self._state, self._at, self._numbering)
            self._mapper.here = self._mapper.underway = None
        return self.locator

    def _search(self, locator: Locator) -> Localise:
        return Localise(self._state, locator, at=self._at, waiting=not self._driving)

    def _to(self, locator: Locator) -> Navigate:
        return Navigate(self._state, locator, at=self._at, waiting=not self._driving)

    def _find_and_explore(self) -> Mission:
        locator = self.locator
        return self._explore() if locator is None else InTurn(self._search(locator), self._explore)

    def _explore(self) -> Mission:
        """Begin to explore; what follows the robot is the mapper again, which knows no more than the locator did."""
        locator, self.locator = self.locator, None
        if locator is not None and not take_over(self._mapper, locator, self._numbering):
            self._forget_lone_nodes()
        return InTurn(Explore(self._state, self._questions, self._mapper), self._home)

    def _forget_lone_nodes(self) -> None:
        """Forget nodes that nothing leads to: without a map nobody knows them again, and they are found anew."""
        graph = self._state.graph
        for node in sorted(graph.nodes):
            if next(graph.neighbours(node), None) is None:
                graph.remove_node(node)
                self._questions.forget(node)

    def _home(self) -> Mission | None:
        """Return the mission that follows an exploration that has ended, if there is one."""
        nodes = self._state.graph.nodes
        if not self.return_home or not nodes:
            return None
        mission = self._to(self._follow())
        mission.go_to(AtNode(min(nodes)))
        return mission
