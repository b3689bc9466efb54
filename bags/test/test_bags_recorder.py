"""A recorded bag opens in the readers others wrote, and holds what was given."""

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from bag_messages import STAMPED, STRING, record_strings, stamped_cdr, string_cdr
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.interfaces import ConnectionExtRosbag2, QosDurability
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from hslam_bags.definitions import DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.qos import LATCHED
from hslam_bags.recorder import Recorder, RecorderConfig
from hslam_types.errors import ConfigurationError


@pytest.mark.parametrize("compression", ["zstd", "none"])
def test_other_readers_read_what_was_written(bag: Path, definitions: DefinitionSource, compression: str) -> None:
    raws = record_strings(bag, definitions, 5000, RecorderConfig(chunk_kb=16, compression=compression))
    with Reader(bag) as reader:
        assert reader.message_count == 5000
        assert [(stamp, raw) for _, stamp, raw in reader.messages()] == [
            (index * 10**6, raw) for index, raw in enumerate(raws)
        ]
    with (bag / "bag_0.mcap").open("rb") as stream:
        mcap = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = mcap.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 5000
        decoded = [message.decoded_message.data for message in mcap.iter_decoded_messages()]
    assert decoded == [f"message {index}" for index in range(5000)]


def test_decodes_by_the_stored_schema_alone(bag: Path, definitions: DefinitionSource) -> None:
    with Recorder(bag, definitions=definitions) as recorder:
        recorder.write("/force", STAMPED, stamped_cdr(1_500_000_000, 2.25), 1_500_000_000)
    with (bag / "bag_0.mcap").open("rb") as stream:
        ((schema, channel, _, message),) = make_reader(
            stream, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages()
    assert schema is not None
    assert (schema.name, schema.encoding, channel.topic) == (STAMPED, "ros2msg", "/force")
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert (message.header.frame_id, message.vector.x) == ("map", 2.25)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(bag) as reader:
        ((connection, _, raw),) = reader.messages()
        decoded: Any = store.deserialize_cdr(raw, connection.msgtype)
    assert decoded.vector.x == 2.25


def test_offered_qos_and_type_hash_are_kept(bag: Path, definitions: DefinitionSource) -> None:
    with Recorder(bag, definitions=definitions, custom={"seed": "7", "note": 'a "b": c'}) as recorder:
        recorder.add_topic("/map", STRING, (LATCHED,))
        recorder.write("/map", STRING, string_cdr("floor"), 5)
    with Reader(bag) as reader:
        (connection,) = reader.connections
        assert isinstance(connection.ext, ConnectionExtRosbag2)
        (offer,) = connection.ext.offered_qos_profiles
        assert (offer.durability, offer.depth) == (QosDurability.TRANSIENT_LOCAL, 1)
        assert connection.digest == "RIHS01_0123"
    stored = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert stored["custom_data"] == {"seed": "7", "note": 'a "b": c'}
    with (bag / "bag_0.mcap").open("rb") as stream:
        (record,) = make_reader(stream).iter_metadata()
    # ros2 bag reads this instead of metadata.yaml where it can, and there without the key around it.
    assert record.name == "rosbag2"
    assert yaml.safe_load(record.metadata["serialized_metadata"]) == stored


def test_splits_by_recorded_time_and_by_size(tmp_path: Path, definitions: DefinitionSource) -> None:
    record_strings(tmp_path / "timed", definitions, 1000, RecorderConfig(split_s=0.3))
    assert sorted(path.name for path in (tmp_path / "timed").glob("*.mcap")) == [f"timed_{n}.mcap" for n in range(4)]
    with Recorder(
        tmp_path / "sized", RecorderConfig(split_mb=1, chunk_kb=64, compression="none"), definitions=definitions
    ) as recorder:
        for index in range(300):
            recorder.write("/chatter", STRING, string_cdr("x" * 10_000), index)
    sizes = [path.stat().st_size for path in sorted((tmp_path / "sized").glob("*.mcap"))]
    assert len(sizes) == 3
    assert max(sizes) < 1.2 * 2**20
    for name, count in (("timed", 1000), ("sized", 300)):
        with Reader(tmp_path / name) as reader:
            assert sum(1 for _ in reader.messages()) == count


def test_same_messages_give_the_same_bytes(tmp_path: Path, definitions: DefinitionSource) -> None:
    for folder in ("one", "two"):
        record_strings(tmp_path / folder / "bag", definitions, 2000, RecorderConfig(chunk_kb=8))
    for name in ("bag_0.mcap", "metadata.yaml"):
        assert (tmp_path / "one/bag" / name).read_bytes() == (tmp_path / "two/bag" / name).read_bytes()


@pytest.fixture
def prefix(tmp_path: Path) -> Path:
    """Return where another process finds the definition of a string."""
    folder = tmp_path / "prefix/share/std_msgs/msg"
    folder.mkdir(parents=True)
    (folder / "String.msg").write_text("string data\n")
    return tmp_path / "prefix"


KILLED = """
import os, signal, sys
from pathlib import Path
from hslam_bags.definitions import DefinitionSource
from hslam_bags.recorder import Recorder
recorder = Recorder(Path(sys.argv[1]), definitions=DefinitionSource([Path(sys.argv[2])]))
for index in range(100):
    recorder.write("/chatter", "std_msgs/msg/String", bytes([0, 1, 0, 0, 2, 0, 0, 0, 48 + index % 10, 0]), index)
recorder.flush()
recorder.write("/chatter", "std_msgs/msg/String", bytes([0, 1, 0, 0, 2, 0, 0, 0, 120, 0]), 100)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_flushed_messages_outlive_a_kill(bag: Path, prefix: Path) -> None:
    """A process that ends without closing leaves a bag that opens as it is, up to the last flush."""
    run = subprocess.run([sys.executable, "-c", KILLED, bag, prefix], check=False)
    assert run.returncode == -signal.SIGKILL
    with Reader(bag) as reader:
        assert reader.message_count == 100
        assert [raw[-2] - 48 for _, _, raw in reader.messages()] == [index % 10 for index in range(100)]


FULL_DISK = """
import sys
from pathlib import Path
from hslam_bags.definitions import DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.recorder import Recorder, RecorderConfig
import random, resource
resource.setrlimit(resource.RLIMIT_FSIZE, (400_000, 400_000))
noise = random.Random(1)
recorder = Recorder(Path(sys.argv[1]), RecorderConfig(chunk_kb=64), definitions=DefinitionSource([Path(sys.argv[2])]))
try:
    for index in range(1000):
        recorder.write("/noise", "std_msgs/msg/String", noise.randbytes(5000), index)
except BagError as error:
    recorder.close()
    sys.exit(str(error))
"""


def test_a_full_disk_says_one_line_and_keeps_what_was_written(bag: Path, prefix: Path) -> None:
    """A file-size limit stands in for the full disk: both refuse a write half way."""
    run = subprocess.run([sys.executable, "-c", FULL_DISK, bag, prefix], capture_output=True, text=True, check=False)
    assert run.returncode == 1
    (line,) = run.stderr.splitlines()
    assert str(bag / "bag_0.mcap") in line
    assert "stay readable" in line
    kept = int(line.rsplit("the ", 1)[1].split()[0])
    assert 50 <= kept < 80
    with Reader(bag) as reader:
        assert [stamp for _, stamp, _ in reader.messages()] == list(range(kept))
        assert reader.message_count == kept


def test_refuses_what_it_cannot_keep(bag: Path, definitions: DefinitionSource) -> None:
    with Recorder(bag, definitions=definitions) as recorder:
        recorder.write("/chatter", STRING, string_cdr("a"), 1)
        with pytest.raises(BagError, match=r"/chatter: is of type std_msgs/msg/String, not geometry"):
            recorder.write("/chatter", STAMPED, b"", 2)
        with pytest.raises(BagError, match=r"no definition of absent_msgs/msg/Thing"):
            recorder.write("/thing", "absent_msgs/msg/Thing", b"", 2)
        for stamp_ns, publish_ns in ((-1, 0), (0, -1), (2**63, 0), (0, 2**64)):
            with pytest.raises(BagError, match=rf"the time {stamp_ns} ns, published {publish_ns} ns"):
                recorder.write("/chatter", STRING, string_cdr("a"), stamp_ns, publish_ns)
    with pytest.raises(BagError, match="closed already"):
        recorder.write("/chatter", STRING, string_cdr("a"), 3)
    with pytest.raises(BagError, match="not empty"):
        Recorder(bag, definitions=definitions)
    with pytest.raises(ConfigurationError, match="neither zstd nor none"):
        RecorderConfig(compression="rar")
