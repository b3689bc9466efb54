"""What one topic of a bag cannot be kept for costs no other topic, is named, and leaves nothing half made."""

import random
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from bag_messages import STAMPED, STRING, string_cdr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

from hslam_bags.bag import Bag
from hslam_bags.definitions import DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.info import info
from hslam_bags.recorder import Recorder
from hslam_bags.repair import copy, repair

RAWS = [string_cdr(str(index)) for index in range(10)]


def good_messages(target: Path) -> list[bytes]:
    """Return the messages of /good of a whole bag."""
    with Bag(target) as bag:
        return [message.raw for message in bag.messages() if message.topic == "/good"]


def mcap_bag(path: Path, topic: str, type_name: str, definition: bytes, log_ns: int = 3) -> None:
    """Write a file with a good topic and one more message."""
    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start()
        schema = writer.register_schema(STRING, "ros2msg", b"string data\n")
        good = writer.register_channel("/good", "cdr", schema)
        other = writer.register_channel(topic, "cdr", writer.register_schema(type_name, "ros2msg", definition))
        for index, raw in enumerate(RAWS):
            writer.add_message(good, index, raw, index)
        writer.add_message(other, log_ns, string_cdr("other"), 3)
        writer.finish()  # type: ignore[no-untyped-call]


@pytest.mark.parametrize(
    ("topic", "type_name", "definition", "log_ns", "told"),
    [
        ("/bad", "absent_msgs/msg/Thing", b"", 3, "topic /bad: is left out: no definition of absent_msgs/msg/Thing"),
        ("/bad", "../../etc", b"", 3, "topic /bad: is left out: '../../etc' is no message type"),
        ("/bad", "x" * 5000 + "/msg/X", b"", 3, "is no message type"),
        ("/bad", "", b"", 3, "topic /bad: is left out: '' is no message type"),
        ("/good", STAMPED, b"x y\n", 3, f"topic /good: is of type {STRING} and of type {STAMPED}, which is left out"),
        ("/bad", STAMPED, b"x y\n", 2**63, "topic /bad: 1 messages have times past the year 2262"),
    ],
)
def test_a_topic_that_cannot_be_kept_is_left_out(
    tmp_path: Path, topic: str, type_name: str, definition: bytes, log_ns: int, told: str
) -> None:
    path = tmp_path / "other.mcap"
    mcap_bag(path, topic, type_name, definition, log_ns)
    mended = repair(path, tmp_path / "mended")
    assert (mended.kept, len(mended.problems)) == (len(RAWS), 1)
    assert told in mended.problems[0]
    assert good_messages(mended.target) == RAWS
    with Bag(path) as bag, pytest.raises(BagError, match="hslam bag repair"):
        copy(bag, tmp_path / "copied")
    assert not (tmp_path / "copied").exists()


def test_a_bag_of_nothing_that_can_be_kept_leaves_no_folder(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start()
        other = writer.register_channel("/bad", "cdr", writer.register_schema("absent_msgs/msg/Thing", "", b""))
        writer.add_message(other, 1, b"", 1)
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(BagError, match="holds no topic that can be copied"):
        repair(path, tmp_path / "mended")
    assert not (tmp_path / "mended").exists()


def test_what_is_in_the_target_already_stays(bag: Path, definitions: DefinitionSource, tmp_path: Path) -> None:
    with Recorder(bag, definitions=definitions) as recorder:
        recorder.write("/good", STRING, RAWS[0], 1)
    (tmp_path / "mended").mkdir()
    (tmp_path / "mended" / "thesis.txt").write_text("precious")
    with pytest.raises(BagError, match="not empty; nothing is overwritten"):
        repair(bag, tmp_path / "mended")
    assert (tmp_path / "mended" / "thesis.txt").read_text() == "precious"


FULL_DISK = """
import resource, sys
from pathlib import Path
from hslam_bags.errors import BagError
from hslam_bags.repair import repair
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
try:
    repair(Path(sys.argv[1]), Path(sys.argv[2]))
except BagError as error:
    sys.exit(str(error))
"""


@pytest.mark.parametrize("made", [True, False])
def test_a_full_disk_leaves_the_target_as_it_was(
    bag: Path, definitions: DefinitionSource, tmp_path: Path, *, made: bool
) -> None:
    """A file-size limit stands in for the full disk."""
    rng = random.Random(1)
    with Recorder(bag, definitions=definitions) as recorder:
        for index in range(200):
            recorder.write("/good", STRING, rng.randbytes(4000), index)
    target = tmp_path / "mended"
    if made:
        target.mkdir()
    run = subprocess.run([sys.executable, "-c", FULL_DISK, bag, target], capture_output=True, text=True, check=False)
    assert run.returncode == 1
    (line,) = run.stderr.splitlines()
    assert "mended_0.mcap: at byte" in line
    assert "stay readable" not in line
    assert list(target.iterdir()) == [] if made else not target.exists()


def database(bag: Path) -> Path:
    """Write a good topic and another to an SQLite bag and return its file."""
    with Writer(bag, version=9) as writer:
        store = get_typestore(Stores.ROS2_JAZZY)
        good = writer.add_connection("/good", STRING, typestore=store)
        other = writer.add_connection("/other", STRING, typestore=store)
        for index, raw in enumerate(RAWS):
            writer.write(good, index, raw)
        writer.write(other, 3, string_cdr("other"))
    return bag / "bag.db3"


EDITS = {
    "UPDATE messages SET timestamp = -5 WHERE topic_id = 2": "topic /other: 1 messages have no time, or one before 0",
    "UPDATE messages SET timestamp = 'noon' WHERE topic_id = 2": "1 messages have no time, or one before 0",
    "UPDATE messages SET timestamp = NULL WHERE topic_id = 2": "1 messages have no time, or one before 0",
    "UPDATE messages SET data = 7 WHERE topic_id = 2": "is no bytes",
    "UPDATE messages SET topic_id = 9 WHERE topic_id = 2": "topic number 9: 1 messages are of no known topic",
    "UPDATE topics SET name = NULL WHERE id = 2": "topic number 2: has no name or no type: None",
    "UPDATE topics SET name = '' WHERE id = 2": "topic number 2: has no name or no type",
    "UPDATE topics SET type = NULL WHERE id = 2": "topic number 2: has no name or no type",
    "UPDATE topics SET type = 'absent_msgs/msg/X' WHERE id = 2": "topic /other: is left out: no definition",
    "UPDATE topics SET name = '/good', type = 'absent_msgs/msg/X' WHERE id = 2": "topic /good: is of type",
    "UPDATE topics SET serialization_format = 7 WHERE id = 2": "topic /other: messages are '7', not cdr",
    "UPDATE topics SET offered_qos_profiles = '- depth:' WHERE id = 2": "topic /other: offered_qos_profiles",
    "UPDATE topics SET offered_qos_profiles = x'00' WHERE id = 2": "topic /other: offered_qos_profiles",
}


def without_constraints(path: Path) -> None:
    """Let the file take what its tables would refuse: the damage that a page can have."""
    with closing(sqlite3.connect(path)) as db:
        db.execute("PRAGMA writable_schema = ON")
        db.execute("UPDATE sqlite_master SET sql = replace(sql, 'NOT NULL', '')")
        db.commit()


def copied(bag: Path, target: Path) -> None:
    """Copy a bag that must be whole."""
    with Bag(bag) as opened:
        copy(opened, target)


@pytest.mark.parametrize("edit", EDITS)
def test_one_bad_row_of_a_database_costs_no_other_topic(bag: Path, tmp_path: Path, edit: str) -> None:
    path = database(bag)
    without_constraints(path)
    with closing(sqlite3.connect(path)) as db:
        db.execute(edit)
        db.commit()
    mended = repair(bag, tmp_path / "mended")
    assert any(EDITS[edit] in problem for problem in mended.problems), mended.problems
    assert good_messages(mended.target) == RAWS
    with pytest.raises(BagError):
        copied(bag, tmp_path / "copied")


CELLS = st.none() | st.integers(-(2**63), 2**63 - 1) | st.text(max_size=5) | st.binary(max_size=5) | st.floats()
COLUMNS = [("topics", name) for name in ("id", "name", "type", "serialization_format", "offered_qos_profiles")]
COLUMNS += [("topics", "type_description_hash"), ("message_definitions", "topic_type")]
COLUMNS += [("message_definitions", name) for name in ("encoding", "encoded_message_definition")]
COLUMNS += [("messages", name) for name in ("id", "topic_id", "timestamp", "data")]


@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(column=st.sampled_from(COLUMNS), cell=CELLS)
def test_no_cell_of_a_database_ends_in_another_error(
    tmp_path_factory: pytest.TempPathFactory, column: tuple[str, str], cell: object
) -> None:
    folder = tmp_path_factory.mktemp("cells")
    path = database(folder / "bag")
    without_constraints(path)
    with closing(sqlite3.connect(path)) as db:
        last = f"(SELECT max(rowid) FROM {column[0]})"  # noqa: S608
        try:
            db.execute(f"UPDATE {column[0]} SET {column[1]} = ? WHERE rowid = {last}", (cell,))  # noqa: S608
        except (sqlite3.IntegrityError, sqlite3.DatabaseError):
            return
        db.commit()
    attempts: list[Callable[[], object]] = [
        lambda: info(folder / "bag", thorough=True),
        lambda: repair(folder / "bag", folder / "mended"),
    ]
    for attempt in attempts:
        try:
            attempt()
        except BagError as error:
            line = str(error)
            assert "\n" not in line
