"""Messages of types that have grown at the end: old bags read and replay, everything else is told apart."""

from pathlib import Path

import pytest
from hslam_msgs.msg import LandmarkObservations
from rclpy.serialization import serialize_message

from hslam_bags.bag import Bag
from hslam_bags.definitions import DefinitionSource
from hslam_bags.grown_types import Decoder, has_grown
from hslam_bags.stored import StoredMessage, StoredTopic
from hslam_ros import conversions
from hslam_types.sensing import FieldOfView

SAMPLES = Path(__file__).parents[1] / "samples"
TYPE = "hslam_msgs/msg/LandmarkObservations"
INSTALLED = DefinitionSource().find(TYPE).text
OLD = INSTALLED.replace(INSTALLED[INSTALLED.index("float64 sensor_x") : INSTALLED.index("=====")], "\n")


@pytest.mark.parametrize("name", ["small_world_1", "small_world_2_heard"])
def test_every_old_look_is_one_all_round(name: str) -> None:
    with Bag(SAMPLES / name) as bag:
        decoder = Decoder(bag.topics.values())
        looks = [conversions.landmarks_from_msg(decoder.decode(msg)) for msg in bag.messages(("/landmarks",))]
        odometry = [conversions.odometry_from_msg(decoder.decode(msg)) for msg in bag.messages(("/odom",))]
    assert len(looks) > 1000
    assert sum(len(look.sightings) for look in looks) > 1000
    assert {look.field for look in looks} == {FieldOfView()}
    assert len(odometry) > len(looks)


@pytest.mark.parametrize(
    ("old", "grown"),
    [
        (OLD, True),
        (OLD.replace("# m, one standard deviation", "# other words") + "\n", True),
        (INSTALLED, False),
        (OLD.replace("float64 range_max", "float32 range_max"), False),
        (OLD.replace("float64[] ranges ", "float64[] distances "), False),
        (OLD.replace("int32 sec", "int64 sec"), False),
        (OLD.replace("float64[] bearing_stds", "float64[] bearing_stds\nfloat64 another"), False),
    ],
)
def test_only_more_fields_at_the_end_are_growth(old: str, *, grown: bool) -> None:
    assert has_grown(old, INSTALLED) is grown


def test_a_message_cut_short_does_not_pass_for_an_old_one() -> None:
    topic = StoredTopic("/landmarks", TYPE, (), "", "ros2msg", INSTALLED)
    raw = serialize_message(LandmarkObservations(ranges=[1.0, 2.0], bearings=[0.5, 0.6]))
    with pytest.raises(Exception, match="deserialize"):
        Decoder([topic]).decode(StoredMessage("/landmarks", TYPE, raw[:40], 0, 0))
