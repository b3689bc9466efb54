"""Who follows the robot: the mapper while the atlas grows, a locator while it is only used; from one to the other."""

import math

from hslam_atlas.localisation.locator import MOST, Locator
from hslam_atlas.localisation.place import ODOM, Place
from hslam_atlas.mapper import Mapper
from hslam_atlas.numbering import Numbering
from hslam_atlas.sighting import view_of
from hslam_atlas.state import AtlasState
from hslam_atlas.uncertain_pose import UncertainPose
from hslam_types.edge_map import EdgeMap
from hslam_types.gvg_events import GvgEvent
from hslam_types.se2 import SE2


def locator_from(mapper: Mapper, state: AtlasState, at: GvgEvent | None, numbering: Numbering) -> Locator:
    """Return a locator that knows what the mapper does; ``at``: the arrival at the node the robot stands at."""
    locator = Locator(state)
    here, underway = mapper.here, mapper.underway
    if underway is not None:
        sequence = numbering.said(underway.sequence)
        locator.places = [Place(underway.node, underway.departure_in_node, sequence, MOST, branch=underway.branch)]
    elif here is not None and here.edge_in_node is not None:
        come = -1 if here.come is None else here.keys.index(here.come)
        traversal = numbering.said(here.traversal)
        locator.places = [Place(here.node, here.edge_in_node, traversal, MOST, here.keys, come)]
    elif here is not None and at is not None:  # new, and nothing was seen on the way: its frame is parallel to odom
        view = view_of(at)
        odom_in_node = SE2(view.x_in_odom, view.y_in_odom, 0.0).inverse()
        locator.places = [Place(here.node, UncertainPose.exact(odom_in_node), ODOM, MOST, here.keys, at.branch)]
    return locator


def take_over(mapper: Mapper, locator: Locator, numbering: Numbering) -> bool:
    """Let the mapper go on from where a locator has the robot, at a node; False where that is in doubt."""
    place, arrived = locator.certain, locator.arrived
    if place is None or arrived is None or not place.keys or place.traversal == ODOM:
        return False
    arrival, edge_map = arrived
    sight_in_node = place.frame_in_node @ UncertainPose.exact(_sight_in_frame(edge_map, locator.whole))
    mapper.take_over(place.node, sight_in_node, numbering.edge_map(edge_map), numbering.event(arrival))
    mapper.track(numbering.drive(place.traversal), place.frame_in_node)
    return True


def _sight_in_frame(edge_map: EdgeMap, whole: bool) -> SE2:
    """Return the frame at the terminal, x back, in the frame the robot is tracked in.

    That is the map's own, or, where the way began on an edge, the one at the access point.
    """
    sight_in_map = SE2(edge_map.terminal_x, 0.0, math.pi)
    return sight_in_map if whole else SE2(0.0, 0.0, -edge_map.departure_heading) @ sight_in_map
