"""Places of the atlas as messages say them."""

from collections.abc import Mapping

from hslam_msgs.msg import Destination as DestinationMsg

from hslam_atlas.missions.destination import AtNode, Destination, DestinationError, OnEdge, check, from_map
from hslam_atlas.state import AtlasState


def destination_from_msg(
    msg: DestinationMsg, state: AtlasState, places: Mapping[str, Destination], here: tuple[float, float] | None
) -> Destination:
    """Return a place that the atlas has; raises DestinationError for one that it has not.

    ``here``: where the robot is (m, `map`), None while that is in doubt.
    """
    if msg.kind == DestinationMsg.NODE:
        found: Destination = AtNode(int(msg.node))
    elif msg.kind == DestinationMsg.ON_EDGE:
        found = OnEdge(int(msg.edge), msg.distance, msg.offset)
    elif msg.kind == DestinationMsg.IN_MAP:
        found = from_map(state.graph, state.maps, msg.point.x, msg.point.y)
    elif msg.kind == DestinationMsg.NAMED:
        if msg.name not in places:
            known = f"; known are: {', '.join(sorted(places))}" if places else ""
            raise DestinationError(f"no place is called '{msg.name}'{known}")
        found = places[msg.name]
    elif msg.kind == DestinationMsg.HERE:
        if here is None:
            raise DestinationError("where the robot is, is in doubt")
        found = from_map(state.graph, state.maps, *here)
    else:
        raise DestinationError(f"there is no kind {msg.kind} of destination")
    return check(found, state.graph)
