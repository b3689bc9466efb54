"""A run's atlas built again from its bag: the same servers hear the same sensors and events."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hslam_msgs.msg import GvgEvent as GvgEventMsg
from hslam_msgs.msg import LandmarkObservations
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message

from hslam_atlas.config import AtlasConfig
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_bags.bag import Bag
from hslam_bags.topic_choice import TopicChoice
from hslam_bringup.errors import RunError
from hslam_ekf.config import EkfConfig
from hslam_ekf.server import EkfServer
from hslam_ros.conversions import event_from_msg, landmarks_from_msg, odometry_from_msg
from hslam_types.gvg_events import GvgEvent
from hslam_types.sensing import LandmarkView, OdometrySample

_TYPES: dict[str, Any] = {"/odom": Odometry, "/landmarks": LandmarkObservations, "/gvg/events": GvgEventMsg}


def rebuild(
    bag: Path, atlas: Path, settings: Mapping[str, Mapping[str, Any]], show: Callable[[int], None] = lambda _: None
) -> AtlasServer:
    """Build the atlas of a recorded run into a new file; ``show`` is told the number of cycles so far.

    Nobody drives: the map comes from the events alone. Raises RunError if the file exists or the bag holds no
    run, BagError on a damaged bag.
    """
    if atlas.exists():
        raise RunError(f"{atlas} exists already; choose another name")
    ekf = EkfServer(EkfConfig.from_mapping(settings.get("ekf", {})))
    cycles = 0
    with Bag(bag) as recorded, AtlasStore(atlas) as store:
        server = AtlasServer(AtlasConfig.from_mapping({"mission": "none"} | dict(settings.get("atlas", {}))), store)
        missing = _TYPES.keys() - recorded.topics.keys()
        if missing:
            raise RunError(f"{bag} holds no {', '.join(sorted(missing))}: there is nothing to build an atlas from")
        for odom, view, events in _cycles(recorded):
            mapped = ekf.step(odom, view, events)
            server.step(odom.stamp_ns, events, mapped.edge_maps, mapped.links)
            cycles += 1
            show(cycles)
    return server


def _cycles(bag: Bag) -> Iterator[tuple[OdometrySample, LandmarkView | None, tuple[GvgEvent, ...]]]:
    """Yield odometry, the look if there was one, and the events of every recorded cycle, in order of stamp."""
    inputs: dict[int, dict[str, list[Any]]] = {}
    convert = {"/odom": odometry_from_msg, "/landmarks": landmarks_from_msg, "/gvg/events": event_from_msg}
    for stored in bag.messages(TopicChoice(tuple(_TYPES))):
        value: Any = convert[stored.topic](deserialize_message(stored.raw, _TYPES[stored.topic]))
        inputs.setdefault(value.stamp_ns, {topic: [] for topic in _TYPES})[stored.topic].append(value)
    for _, cycle in sorted(inputs.items()):
        if cycle["/odom"]:
            yield cycle["/odom"][0], (cycle["/landmarks"] or [None])[0], tuple(cycle["/gvg/events"])
