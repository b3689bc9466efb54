"""Bags of every kind are read alike, damaged ones as far as they go."""

import contextlib
import random
import shutil
import sqlite3
import struct
from collections.abc import Callable
from pathlib import Path

import pytest
from backports import zstd
from bag_messages import STRING, record_strings, string_cdr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from hslam_bags.bag import Bag
from hslam_bags.commands import parameter_arguments
from hslam_bags.definitions import DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.info import info
from hslam_bags.qos import LATCHED
from hslam_bags.recorder import Recorder, RecorderConfig
from hslam_bags.repair import repair
from hslam_bags.topic_choice import TopicChoice

COUNT = 2000
SMALL_CHUNKS = RecorderConfig(chunk_kb=8)


def read(path: Path, *, tolerant: bool = False) -> list[tuple[int, bytes]]:
    """Return (log time, bytes) of every message."""
    with Bag(path, tolerant=tolerant) as bag:
        return [(message.log_ns, message.raw) for message in bag.messages()]


def expected(raws: list[bytes]) -> list[tuple[int, bytes]]:
    """Return what `record_strings` recorded."""
    return [(index * 10**6, raw) for index, raw in enumerate(raws)]


@pytest.mark.parametrize("config", [SMALL_CHUNKS, RecorderConfig(chunk_kb=8, split_s=0.5, compression="none")])
def test_reads_what_was_recorded(bag: Path, definitions: DefinitionSource, config: RecorderConfig) -> None:
    raws = record_strings(bag, definitions, COUNT, config)
    assert read(bag) == expected(raws)
    with Bag(bag) as opened:
        window = [message.log_ns for message in opened.messages(start_ns=500 * 10**6, end_ns=700 * 10**6)]
        assert window == [index * 10**6 for index in range(500, 700)]
        assert opened.span_ns == (0, (COUNT - 1) * 10**6)
        assert list(opened.messages(TopicChoice(("other",)))) == []


LAYOUTS = [
    (StoragePlugin.MCAP, CompressionMode.NONE),
    (StoragePlugin.MCAP, CompressionMode.STORAGE),
    (StoragePlugin.MCAP, CompressionMode.FILE),
    (StoragePlugin.SQLITE3, CompressionMode.NONE),
    (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    (StoragePlugin.SQLITE3, CompressionMode.FILE),
]


@pytest.mark.parametrize(("plugin", "mode"), LAYOUTS)
@pytest.mark.parametrize("version", [8, 9])
def test_reads_bags_that_rosbags_wrote(bag: Path, plugin: StoragePlugin, mode: CompressionMode, version: int) -> None:
    no_limit = QosTime(9223372036, 854775807)
    latched = Qos(
        QosHistory.KEEP_LAST,
        1,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL,
        no_limit,
        no_limit,
        QosLiveliness.AUTOMATIC,
        no_limit,
        False,
    )
    writer = Writer(bag, version=9 if version == 9 else 8, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        store = get_typestore(Stores.ROS2_JAZZY)
        connection = writer.add_connection("/map", STRING, typestore=store, offered_qos_profiles=[latched])
        for index in range(100):
            writer.write(connection, index * 10, string_cdr(str(index)))
    assert read(bag) == [(index * 10, string_cdr(str(index))) for index in range(100)]
    with Bag(bag) as opened:
        topic = opened.topics["/map"]
        assert topic.offers == (LATCHED,)
        assert "string data" in topic.definition
        assert opened.counts == {"/map": 100}


def test_reads_mcap_whose_messages_were_packed_one_by_one(bag: Path, definitions: DefinitionSource) -> None:
    """As `ros2 bag record -s mcap --compression-mode message` leaves it."""
    with Recorder(bag, SMALL_CHUNKS, definitions=definitions) as recorder:
        for index in range(100):
            packed = zstd.compress(string_cdr(str(index)))
            recorder.write("/chatter", STRING, packed if index else b"no zstd", index * 10)
    listed = bag / "metadata.yaml"
    listed.write_text(listed.read_text().replace('compression_mode: ""', "compression_mode: MESSAGE"))
    with pytest.raises(BagError, match="topic /chatter at 0 ns: a message cannot be unpacked"):
        read(bag)
    assert read(bag, tolerant=True) == [(index * 10, string_cdr(str(index))) for index in range(1, 100)]


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("index", [IndexType.ALL, IndexType.NONE])
@pytest.mark.parametrize("chunking", [True, False])
def test_reads_files_that_mcap_wrote(
    tmp_path: Path, compression: CompressionType, index: IndexType, *, chunking: bool
) -> None:
    """Unindexed, unchunked and unsorted files are in order when read."""
    path = tmp_path / "other.mcap"
    order = list(range(300))
    random.Random(4).shuffle(order)
    with path.open("wb") as stream:
        writer = McapWriter(stream, 512, compression, index, use_chunking=chunking)
        writer.start("ros2")
        schema = writer.register_schema(STRING, "ros2msg", b"string data\n")
        channel = writer.register_channel("/chatter", "cdr", schema)
        for number in order:
            writer.add_message(channel, number, string_cdr(str(number)), number)
        writer.finish()  # type: ignore[no-untyped-call]
    assert read(path) == [(number, string_cdr(str(number))) for number in range(300)]


Damage = Callable[[Path], object]


def edit(name: str, change: Callable[[bytes], bytes]) -> Damage:
    """Return what changes one file of a bag."""

    def damage(bag: Path) -> None:
        path = bag / name
        path.write_bytes(change(path.read_bytes()))

    return damage


def flip(data: bytes, at: int) -> bytes:
    """Return the data with one byte changed."""
    return data[:at] + bytes([data[at] ^ 0x5A]) + data[at + 1 :]


def with_boundless_chunk(data: bytes) -> bytes:
    """Return a file whose first chunk says that it unpacks to 2^64 - 1 bytes."""
    at = data.find(b"\x06", 500) + struct.calcsize("<BQQQ")
    return data[:at] + b"\xff" * 8 + data[at + 8 :]


DAMAGES: dict[str, tuple[Damage, str, int]] = {
    "cut in half": (
        edit("bag_0.mcap", lambda d: d[: len(d) // 2]),
        r"bag_0.mcap: summary: the file's end is missing",
        900,
    ),
    "no end": (edit("bag_0.mcap", lambda d: d[:-1]), r"bag_0.mcap: summary: the file's end is missing", COUNT),
    "one byte of a chunk": (
        edit("bag_0.mcap", lambda d: flip(d, len(d) // 3)),
        r"bag_0.mcap: chunk at byte \d+: ",
        1700,
    ),
    "a length": (
        edit("bag_0.mcap", lambda d: flip(d[: len(d) // 2], d.find(b"\x06", 500) + 5)),
        r"summary: the file's end",
        900,
    ),
    "a chunk's size": (
        edit("bag_0.mcap", with_boundless_chunk),
        r"bag_0.mcap: chunk at byte \d+: its head is damaged; what it holds is whole",
        COUNT,
    ),
    "the summary": (
        edit("bag_0.mcap", lambda d: flip(d, len(d) - 200)),
        r"summary: the summary at byte \d+ differs",
        COUNT,
    ),
    "metadata gone": (lambda bag: (bag / "metadata.yaml").unlink(), r"metadata.yaml: is missing", COUNT),
    "metadata is no YAML": (
        edit("metadata.yaml", lambda _: b"a: [1,\nb: }"),
        r"metadata.yaml: line \d+: is not YAML",
        COUNT,
    ),
    "metadata is of something else": (edit("metadata.yaml", lambda _: b"a: 1\n"), r"is no rosbag2 metadata", COUNT),
    "a file too many": (
        lambda bag: shutil.copy(bag / "bag_0.mcap", bag / "bag_1.mcap"),
        r"bag_1.mcap: is not listed",
        COUNT,
    ),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damage_is_named_and_the_rest_offered(bag: Path, definitions: DefinitionSource, name: str) -> None:
    damage, message, least = DAMAGES[name]
    raws = record_strings(bag, definitions, COUNT, SMALL_CHUNKS)
    damage(bag)
    with pytest.raises(BagError, match=message) as caught:
        read(bag)
    assert "\n" not in str(caught.value)
    assert "hslam bag repair" in str(caught.value)
    readable = read(bag, tolerant=True)
    assert set(readable) <= set(expected(raws))
    assert len(readable) >= least
    assert info(bag, thorough=True).problems
    mended = repair(bag, bag.with_name("mended"))
    assert mended.kept == len(readable)
    assert mended.problems
    assert read(mended.target) == readable


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"", "is empty"), (b"GIF89a, not a bag at all", "at byte 0: is no MCAP file")],
)
def test_what_is_no_bag_is_said_so(bag: Path, content: bytes, message: str) -> None:
    bag.mkdir()
    with pytest.raises(BagError, match=r"holds no \.mcap or \.db3"), Bag(bag, tolerant=True):
        pass
    (bag / "bag_0.mcap").write_bytes(content)
    with pytest.raises(BagError, match=message):
        read(bag / "bag_0.mcap")
    with pytest.raises(BagError, match=f"{message}; nothing is readable"):
        repair(bag / "bag_0.mcap")
    with pytest.raises(BagError, match="does not exist"):
        read(bag / "absent.mcap")


def test_messages_of_no_known_type_are_named(tmp_path: Path) -> None:
    path = tmp_path / "mixed.mcap"
    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start()
        schema = writer.register_schema("thing", "jsonschema", b"{}")
        writer.add_message(writer.register_channel("/json", "json", schema), 1, b"{}", 1)
        known = writer.register_schema(STRING, "ros2msg", b"string data\n")
        writer.add_message(writer.register_channel("/chatter", "cdr", known), 2, string_cdr("a"), 2)
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(BagError, match="topic /json: messages are 'json', not cdr"):
        read(path)
    assert read(path, tolerant=True) == [(2, string_cdr("a"))]


def test_a_damaged_database_is_named(bag: Path) -> None:
    with Writer(bag, version=9) as writer:
        connection = writer.add_connection("/chatter", STRING, typestore=get_typestore(Stores.ROS2_JAZZY))
        for index in range(5000):
            writer.write(connection, index, string_cdr(str(index)))
    path = bag / "bag.db3"
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BagError, match=r"bag.db3: .*(malformed|damaged)"):
        read(bag)
    path.write_bytes(b"")
    with pytest.raises(BagError, match=r"bag.db3: is empty"):
        read(bag)
    path.unlink()
    sqlite3.connect(path).execute("CREATE TABLE other (id)").connection.close()
    with pytest.raises(BagError, match=r"bag.db3: table topics: is missing"):
        read(bag)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_no_damage_crashes_the_reader_or_forges_a_message(
    tmp_path_factory: pytest.TempPathFactory, definitions: DefinitionSource, data: st.DataObject
) -> None:
    """Flipped bytes and cuts: every message that is offered is one that was recorded."""
    bag = tmp_path_factory.mktemp("fuzz") / "bag"
    with Recorder(bag, RecorderConfig(chunk_kb=1), definitions=definitions) as recorder:
        for index in range(100):
            recorder.write("/chatter", STRING, string_cdr(f"message {index}"), index)
    path = bag / "bag_0.mcap"
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    path.write_bytes(content[: data.draw(st.integers(1, len(content)))])
    with contextlib.suppress(BagError):  # nothing is readable
        offered = read(path, tolerant=True)
        assert {raw for _, raw in offered} <= {string_cdr(f"message {index}") for index in range(100)}


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_no_damage_to_a_database_is_an_unknown_error(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """SQLite has no checksums, so nothing vouches for what is offered; but every refusal is a BagError of one line."""
    bag = tmp_path_factory.mktemp("fuzz") / "bag"
    with Writer(bag, version=9) as writer:
        connection = writer.add_connection("/chatter", STRING, typestore=get_typestore(Stores.ROS2_JAZZY))
        for index in range(100):
            writer.write(connection, index, string_cdr(str(index)))
    path = bag / "bag.db3"
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 6))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    for tolerant in (False, True):
        try:
            messages = read(bag, tolerant=tolerant)
        except BagError as error:
            line = str(error)
            assert str(bag) in line
            assert "\n" not in line
        else:
            assert all(isinstance(raw, bytes) for _, raw in messages)


def test_settings_reach_a_node_as_what_they_are() -> None:
    """A topic or folder that looks like a number stays text."""
    given_settings: dict[str, bool | int | float | str] = {"path": "2026", "rate": 2.0, "paused": True, "chunk_kb": 8}
    expected_arguments = [
        "--ros-args",
        "-p",
        'path:="2026"',
        "-p",
        "rate:=2.0",
        "-p",
        "paused:=true",
        "-p",
        "chunk_kb:=8",
    ]
    assert parameter_arguments(given_settings) == expected_arguments
