"""A bag through the EKF and atlas levels in this process: the recorded sensors and events make an atlas anew.

With the run's own parameters it is the run's atlas, bit for bit; with others it shows what they would have made of it.
"""

from pathlib import Path
from typing import Any

from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import StoreError
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_atlas.store_file import beside
from hslam_bags.bag import Bag
from hslam_bags.cycles import Portion, in_portions, in_stamp_order, stamp_of
from hslam_bags.errors import BagError
from hslam_bags.grown_types import Decoder
from hslam_bags.topic_choice import TopicChoice
from hslam_bringup.run_options import RunOptions
from hslam_ekf.config import EkfConfig
from hslam_ekf.server import EkfServer
from hslam_ros import conversions

TOPICS = ("/odom", "/landmarks", "/gvg/events")
"""What the two levels hear of the base and of the GVG level."""


class BagLoop:
    """Steps the EKF and the atlas by the cycles of a bag."""

    def __init__(self, ekf: EkfServer, atlas: AtlasServer, decoder: Decoder) -> None:
        """Take the levels as they are, and what decodes the bag; the atlas must not explore."""
        self.ekf, self.atlas = ekf, atlas
        self._decoder = decoder

    def step(self, portion: Portion) -> None:
        """Handle one cycle: what was recorded since the one before."""
        heard: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
        for message in portion.messages:
            heard[message.topic].append(self._decoder.decode(message))
        odom = conversions.odometry_from_msg(heard["/odom"][-1])
        looks = [conversions.landmarks_from_msg(msg) for msg in heard["/landmarks"]]
        events = tuple(conversions.event_from_msg(msg) for msg in heard["/gvg/events"])
        mapped = self.ekf.step(odom, looks[-1] if looks else None, events)
        self.atlas.step(events, mapped.edge_maps, mapped.links)


def rebuild_atlas(bag: Bag, options: RunOptions) -> int:
    """Make ``options.atlas`` of an open bag, with ``options.settings`` for ekf and atlas; return the number of cycles.

    An earlier atlas is there until the new one is whole, and stays where none comes of it.  Raises BagError if the bag
    is damaged or lacks a topic, MessageError if it holds what no node takes, ConfigurationError on a bad setting,
    StoreError if the atlas cannot be written.
    """
    for topic in TOPICS:
        if not bag.counts.get(topic):
            raise BagError(bag.path, f"topic {topic}", "is not in the bag, and no atlas is made without it")
    partial = options.atlas.with_name(f"{options.atlas.name}.part")
    _remove(partial, *beside(partial))
    try:
        with AtlasStore(partial) as store:
            cycles = _build(bag, options, store)
        _remove(*beside(options.atlas))  # they would be taken for the new one's
        partial.replace(options.atlas)
    except OSError as error:
        raise StoreError(f"{options.atlas}: cannot be written ({error})") from error
    finally:
        _remove(partial, *beside(partial))
    return cycles


def _build(bag: Bag, options: RunOptions, store: AtlasStore) -> int:
    loop = BagLoop(
        EkfServer(EkfConfig.from_mapping(options.node_settings("ekf"))),
        AtlasServer(AtlasConfig.from_mapping(options.node_settings("atlas") | {"mission": "none"}), store),
        Decoder(bag.topics.values()),
    )
    cycles = 0
    for portion in in_portions(in_stamp_order(bag.messages(TopicChoice(TOPICS)), stamp_of), "/odom"):
        if portion.complete:
            loop.step(portion)
            cycles += 1
    loop.atlas.save_rest()
    return cycles


def _remove(*paths: Path) -> None:
    for path in paths:
        path.unlink(missing_ok=True)
