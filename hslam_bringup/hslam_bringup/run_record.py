"""Records a run in one process under the topics, types and QoS that the nodes publish it with."""

from typing import Any

from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message

from hslam_bags.recorder import Recorder
from hslam_bags.ros_qos import offer_from_profile
from hslam_ros.qos import CYCLE, EVENTS, LATCHED

_LATCHED = frozenset({"/bumper", "/atlas/atlas", "/tf_static"})
_EVENTS = frozenset({"/gvg/events", "/ekf/edge_maps", "/ekf/frame_links"})


class RunRecord:
    """Serialises messages into a bag, as the recorder of a run in many processes would receive them."""

    def __init__(self, recorder: Recorder) -> None:
        """Write to ``recorder``, which the caller closes."""
        self._recorder = recorder
        self._types: dict[str, str] = {}

    def put(self, topic: str, msg: Any, stamp_ns: int) -> None:
        """Record one message under its absolute topic; raises BagError when the disk is full."""
        type_name = self._types.get(topic)
        if type_name is None:
            package, _, _ = type(msg).__module__.partition(".")
            type_name = self._types[topic] = f"{package}/msg/{type(msg).__name__}"
            self._recorder.add_topic(topic, type_name, (offer_from_profile(_profile(topic)),))
        self._recorder.write(topic, type_name, serialize_message(msg), stamp_ns)


def _profile(topic: str) -> QoSProfile:
    if topic in _EVENTS:
        return EVENTS
    return LATCHED if topic in _LATCHED else CYCLE
