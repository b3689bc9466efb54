"""Where a bag's scanner is mounted, by the bag's own static transforms."""

from typing import Any

from hslam_bags.bag import Bag
from hslam_bags.grown_types import Decoder
from hslam_bags.topic_choice import TopicChoice
from hslam_ros.conversions import yaw_from_quaternion
from hslam_types.se2 import SE2

STATIC = "/tf_static"
_MOST_FRAMES = 50
"""A chain of more frames than this goes round in circles."""


def scanner_in_base(bag: Bag, base: str, scanner: str) -> SE2 | None:
    """Return the planar pose of frame ``scanner`` in frame ``base``; None where the bag's transforms do not say."""
    decoder = Decoder(bag.topics.values())
    parents: dict[str, tuple[str, SE2]] = {}
    for message in bag.messages(TopicChoice((STATIC,))):
        for transform in decoder.decode(message).transforms:
            parents[_plain(transform.child_frame_id)] = _plain(transform.header.frame_id), _planar(transform)
    frame, pose = _plain(scanner), SE2()
    for _ in range(_MOST_FRAMES):
        if frame == _plain(base):
            return pose
        if frame not in parents:
            break
        frame, in_parent = parents[frame]
        pose = in_parent @ pose
    return None


def _plain(frame: str) -> str:
    return frame.removeprefix("/")


def _planar(msg: Any) -> SE2:
    place = msg.transform.translation
    return SE2(place.x, place.y, yaw_from_quaternion(msg.transform.rotation))
