"""QoS texts and topic names of any shape: read or named, and written so that any YAML reader gets them back."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from bag_messages import STRING, string_cdr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import Reader

from hslam_bags.bag import Bag
from hslam_bags.definitions import DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.info import info
from hslam_bags.metadata import FileInfo, Metadata, TopicInfo, to_record, to_yaml
from hslam_bags.qos import INFINITE_NS, OfferedQos, qos_from_yaml, qos_to_yaml
from hslam_bags.recorder import Recorder
from hslam_bags.repair import repair

WORDS = st.sampled_from(["system_default", "unknown"])
OFFERS = st.builds(
    OfferedQos,
    history=WORDS | st.just("keep_all"),
    depth=st.integers(0, 2**31 - 1),
    reliability=WORDS | st.just("best_effort"),
    durability=WORDS | st.just("transient_local"),
    deadline_ns=st.integers(1, INFINITE_NS),
    lifespan_ns=st.integers(1, INFINITE_NS),
    liveliness=WORDS | st.just("manual_by_topic"),
    lease_ns=st.integers(1, INFINITE_NS),
)


@given(st.lists(OFFERS, max_size=3).map(tuple))
def test_offers_come_back_as_they_were(offers: tuple[OfferedQos, ...]) -> None:
    assert qos_from_yaml(qos_to_yaml(offers)) == offers


BAD_TEXTS = [
    "- depth:",
    "- depth: .inf",
    "- depth: 1e20",
    "- depth: -1",
    "- depth: 2147483648",
    "- depth: true",
    "- deadline:\n    sec:",
    "- lifespan: {sec: .inf}",
    "- deadline: {sec: 1, nsec: [2]}",
    "[" * 1000,
    "- history: " + "[" * 1000 + "]" * 1000,
    "depth: 3",
    "- 7",
    "1" * 5000,
]


@pytest.mark.parametrize("text", BAD_TEXTS)
def test_an_offer_that_cannot_be_is_named(text: str) -> None:
    with pytest.raises(ValueError, match="offered_qos_profiles"):
        qos_from_yaml(text)


SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.dates()
FIELDS = ["history", "depth", "reliability", "durability", "deadline", "lifespan", "liveliness", "sec", "nsec"]
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(FIELDS), inner), max_leaves=12
)


@given(st.lists(st.dictionaries(st.sampled_from(FIELDS), VALUES), max_size=2) | VALUES)
def test_no_shape_of_a_profile_is_another_error(stored: object) -> None:
    """A list's text, or what a database holds in that column; a depth that comes through is one that DDS takes."""
    for given_value in (yaml.safe_dump(stored), stored):
        try:
            offers = qos_from_yaml(given_value)
        except ValueError:
            continue
        assert all(0 <= offer.depth < 2**31 and offer.deadline_ns > 0 for offer in offers)


@pytest.mark.parametrize("text", BAD_TEXTS)
def test_a_bag_with_such_an_offer_is_described_and_repaired(tmp_path: Path, text: str) -> None:
    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start()
        schema = writer.register_schema(STRING, "ros2msg", b"string data\n")
        channel = writer.register_channel("/chatter", "cdr", schema, {"offered_qos_profiles": text})
        writer.add_message(channel, 5, string_cdr("a"), 5)
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(BagError, match="topic /chatter: offered_qos_profiles"):
        Bag(path)
    (problem,) = info(path, thorough=True).problems
    assert "topic /chatter: offered_qos_profiles" in problem
    mended = repair(path, tmp_path / "mended")
    assert mended.problems == (problem,)
    with Bag(mended.target) as bag:
        assert [message.raw for message in bag.messages()] == [string_cdr("a")]


NAMES = st.text(st.characters(codec="utf-8"), min_size=1)


@given(name=NAMES, custom=st.dictionaries(NAMES, NAMES, max_size=3))
def test_metadata_of_any_name_is_read_as_it_was(name: str, custom: dict[str, str]) -> None:
    metadata = Metadata((TopicInfo(name, name, (), name, 1),), (FileInfo(name, (1, 2), 1),), custom)
    whole: Any = yaml.safe_load(to_yaml(metadata))["rosbag2_bagfile_information"]
    topic = whole["topics_with_message_count"][0]["topic_metadata"]
    assert (topic["name"], topic["type"], topic["type_description_hash"]) == (name, name, name)
    assert whole["relative_file_paths"] == [name]
    assert whole["files"][0]["path"] == name
    assert (whole["custom_data"] or {}) == custom
    assert yaml.safe_load(to_record(metadata)) == whole


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=NAMES | st.sampled_from(["/a: [b", "/a\nb", "- x", "/[/b]", "~", "1e5", "/\U0001f600"]))
def test_a_topic_of_any_name_is_recorded_and_read(
    tmp_path_factory: pytest.TempPathFactory, definitions: DefinitionSource, name: str
) -> None:
    bag = tmp_path_factory.mktemp("named") / "bag"
    with Recorder(bag, definitions=definitions, custom={"note": name}) as recorder:
        recorder.write(name, STRING, string_cdr("a"), 1)
    assert not info(bag, thorough=True).problems
    with Bag(bag) as opened:
        assert opened.counts == {name: 1}
        assert opened.custom == {"note": name}
    with Reader(bag) as reader:
        assert [connection.topic for connection in reader.connections] == [name]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[" * 5000, "is not YAML: is nested too deeply"),
        ("rosbag2_bagfile_information: {relative_file_paths: [1]}", "is no rosbag2 metadata"),
        ("rosbag2_bagfile_information: {relative_file_paths: bag_0.mcap}", "is no rosbag2 metadata"),
        (f"rosbag2_bagfile_information: {{relative_file_paths: [{'x' * 5000}]}}", "is missing, though metadata.yaml"),
        ('rosbag2_bagfile_information: {relative_file_paths: [], custom_data: {a: "\\ud800"}}', "no rosbag2 metadata"),
        ("rosbag2_bagfile_information: {relative_file_paths: [], custom_data: [1]}", "is no rosbag2 metadata"),
        ("rosbag2_bagfile_information: 2026-13-45", "is no rosbag2 metadata"),
    ],
)
def test_metadata_that_cannot_be_is_named(bag: Path, definitions: DefinitionSource, text: str, told: str) -> None:
    with Recorder(bag, definitions=definitions) as recorder:
        recorder.write("/chatter", STRING, string_cdr("a"), 1)
    (bag / "metadata.yaml").write_text(text)
    found = info(bag, thorough=True)
    assert any(told in problem for problem in found.problems), found.problems
    assert found.message_count == 1
    assert repair(bag, bag.with_name("mended")).kept == 1
