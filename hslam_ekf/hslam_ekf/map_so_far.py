"""The map of the traversal under way, for whoever asks: to know a place by it, nobody has to wait for an arrival."""

from hslam_msgs.srv import MapSoFar
from rclpy.logging import get_logger

from hslam_ekf.errors import EkfError
from hslam_ekf.server import EkfServer
from hslam_ros import conversions
from hslam_types.errors import MessageError


def map_so_far(
    server: EkfServer, stamp_ns: int, request: MapSoFar.Request, response: MapSoFar.Response
) -> MapSoFar.Response:
    """Answer with the map as it is at ``stamp_ns``; no success where no traversal is under way."""
    try:
        arrival = conversions.event_from_msg(request.arrival) if request.at_arrival else None
        edge_map = server.so_far(arrival)
    except (MessageError, EkfError) as error:
        get_logger("ekf").warning(f"no map so far: {error}")
        return response
    if edge_map is not None:
        response.success, response.edge_map = True, conversions.edge_map_to_msg(edge_map, stamp_ns)
    return response
