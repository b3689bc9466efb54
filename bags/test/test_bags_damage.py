"""Damage of any kind, anywhere in a bag: it is named, costs no more than its chunk, and ends in no traceback."""

import contextlib
import random
import shutil
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import pytest
from backports import zstd
from bag_messages import STRING, string_cdr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter

from hslam_bags import mcap_parsing, mcap_records
from hslam_bags.bag import Bag
from hslam_bags.definitions import DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.info import info
from hslam_bags.mcap_packing import LARGEST, unpack
from hslam_bags.mcap_records import MAGIC, Op
from hslam_bags.mcap_storage import McapStorage
from hslam_bags.recorder import Recorder, RecorderConfig
from hslam_bags.repair import repair

SAMPLE = Path(__file__).parents[1] / "samples" / "small_world_2_heard"
COUNT = 60
RAWS = [string_cdr(f"message {index}") for index in range(COUNT)]


def test_a_chunk_by_another_opcode_is_named_and_kept(tmp_path: Path) -> None:
    """The sample's byte 566870 begins a chunk: read by its index alone, it is silently no messages at all."""
    bag = tmp_path / SAMPLE.name
    shutil.copytree(SAMPLE, bag)
    path = bag / "small_world_2_heard_0.mcap"
    whole = info(bag, thorough=True)
    assert whole.problems == ()
    content = bytearray(path.read_bytes())
    assert content[566870] == Op.CHUNK
    content[566870] = 0x86
    path.write_bytes(content)
    (problem,) = info(bag, thorough=True).problems
    assert "at byte 566870: opcode 134" in problem
    mended = repair(bag, tmp_path / "mended")
    assert mended.problems == (problem,)
    assert mended.kept == whole.message_count == 4152
    with pytest.raises(BagError, match=r"at byte 566870: opcode 134.*hslam bag repair"):
        Bag(bag)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, definitions: DefinitionSource) -> bytes:
    """Return a file of three chunks, as the recorder writes it."""
    bag = tmp_path_factory.mktemp("whole") / "bag"
    with Recorder(bag, RecorderConfig(chunk_kb=1), definitions=definitions) as recorder:
        for index, raw in enumerate(RAWS):
            recorder.write("/chatter", STRING, raw, index)
    return (bag / "bag_0.mcap").read_bytes()


def chunks(data: bytes) -> dict[int, tuple[int, list[bytes]]]:
    """Return each chunk's end and messages by the byte at which it begins."""
    found = {}
    for op, offset, content in mcap_parsing.records(memoryview(data), len(MAGIC), len(data) - len(MAGIC)):
        if op == Op.CHUNK:
            head = mcap_parsing.chunk_head(content)
            inner = zstd.decompress(content[head.begin : head.end])
            messages = [
                mcap_parsing.message(record)[3]
                for kind, _, record in mcap_parsing.records(memoryview(inner), 0, len(inner))
                if kind == Op.MESSAGE
            ]
            found[offset] = offset + 9 + len(content), messages
    return found


def read(path: Path) -> tuple[list[bytes], list[BagError]]:
    """Return what a damaged file still offers, and what is said of it."""
    problems: list[BagError] = []
    storage = McapStorage(path, problems.append)
    try:
        messages = [message.raw for message in storage.messages({"/chatter"}, 0, 2**64)]
        storage.check()
    finally:
        storage.close()
    return messages, problems


def test_the_checksum_over_the_whole_is_the_format_s(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    path.write_bytes(whole)
    with path.open("rb") as stream:
        assert sum(1 for _ in StreamReader(stream, validate_crcs=True).records) > COUNT
    path.write_bytes(whole.replace(b"hslam_bags 1", b"hslam_bags 2"))
    assert [problem.problem for problem in read(path)[1]] == ["the data differ from their checksum"]


def test_no_changed_byte_goes_unnoticed_or_costs_more_than_its_chunk(whole: bytes, tmp_path: Path) -> None:
    """Bytes all over the file in turn: what is outside the chunk it is in is offered, and damage is told."""
    path = tmp_path / "bag.mcap"
    rng = random.Random(5)
    where = chunks(whole)
    assert len(where) >= 3
    for at in range(0, len(whole), 3):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ rng.randrange(1, 256)]) + whole[at + 1 :])
        if at < len(MAGIC):
            with pytest.raises(BagError, match="is no MCAP file"):
                read(path)
            continue
        offered, problems = read(path)
        assert problems, f"byte {at}: called whole"
        lost = next((messages for begin, (end, messages) in where.items() if begin <= at < end), [])
        missing = [raw for raw in RAWS if raw not in offered]
        assert not missing or missing == lost, f"byte {at}"
        assert len(offered) + len(missing) == COUNT, f"byte {at}: a message is there twice"
        if missing:
            assert any("messages that the file counts" in problem.problem for problem in problems), f"byte {at}"


def test_a_chunk_s_head_costs_nothing(whole: bytes, tmp_path: Path) -> None:
    """What a chunk says of itself stands in the index too; without one its checksum tells what is right."""
    path = tmp_path / "bag.mcap"
    for indexed in (True, False):
        data = whole if indexed else whole[:-1]
        offset, (end, _) = next(iter(chunks(whole).items()))
        crc_at, packing_at = offset + 9 + 24, offset + 9 + 28 + 4
        for at in range(offset, packing_at + 4 + 8):
            if crc_at <= at < crc_at + 4 or (not indexed and packing_at - 4 <= at < packing_at):
                continue
            path.write_bytes(data[:at] + bytes([data[at] ^ 0x41]) + data[at + 1 :])
            offered, problems = read(path)
            assert offered == RAWS, f"byte {at} of the chunk from {offset} to {end}, indexed: {indexed}"
            assert len(problems) >= 1 + (not indexed and not offset + 9 <= at < crc_at - 8)


def test_no_cut_goes_unnoticed_or_costs_more_than_what_is_behind_it(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    where = chunks(whole)
    for length in range(len(MAGIC), len(whole), 13):
        path.write_bytes(whole[:length])
        offered, problems = read(path)
        assert problems
        assert offered == RAWS[: len(offered)]
        assert len(offered) >= sum(len(messages) for end, messages in where.values() if end <= length)


def other_file(path: Path, index: IndexType, compression: CompressionType, *, chunking: bool, crcs: bool) -> None:
    """Write a file as others do, with checksums or without."""
    with path.open("wb") as stream:
        writer = McapWriter(stream, 512, compression, index, use_chunking=chunking, enable_crcs=crcs)
        writer.start("ros2")
        schema = writer.register_schema(STRING, "ros2msg", b"string data\n")
        channel = writer.register_channel("/chatter", "cdr", schema)
        for number, raw in enumerate(RAWS):
            writer.add_message(channel, number, raw, number)
        writer.finish()  # type: ignore[no-untyped-call]


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    index=st.sampled_from([IndexType.ALL, IndexType.NONE]),
    compression=st.sampled_from(list(CompressionType)),
    chunking=st.booleans(),
    crcs=st.booleans(),
    changes=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(1, 255)), min_size=1, max_size=3),
)
def test_no_message_of_others_files_is_lost_without_a_word(
    tmp_path_factory: pytest.TempPathFactory,
    index: IndexType,
    compression: CompressionType,
    changes: list[tuple[float, int]],
    *,
    chunking: bool,
    crcs: bool,
) -> None:
    """Without checksums a changed message cannot be told from another; that one is missing can."""
    path = tmp_path_factory.mktemp("other") / "other.mcap"
    other_file(path, index, compression, chunking=chunking, crcs=crcs)
    content = bytearray(path.read_bytes())
    for where, change in changes:
        content[int(where * len(content))] ^= change
    path.write_bytes(content)
    with contextlib.suppress(BagError):
        found = info(path, thorough=True)
        with Bag(path, tolerant=True) as bag:
            messages = sum(1 for _ in bag.messages())
        assert found.problems or messages == COUNT
    with contextlib.suppress(BagError):
        mended = repair(path)
        assert info(mended.target, thorough=True).message_count == mended.kept


def test_a_lost_length_of_a_message_outside_chunks_costs_that_message(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    other_file(path, IndexType.NONE, CompressionType.NONE, chunking=False, crcs=True)
    content = bytearray(path.read_bytes())
    at = content.find(RAWS[30]) - 31
    assert content[at] == Op.MESSAGE
    content[at + 4] = 0x7F
    path.write_bytes(content)
    offered, problems = read(path)
    assert offered == RAWS[:30] + RAWS[31:]
    assert [problem.place for problem in problems] == [f"at byte {at}", "topic /chatter"]


def test_an_index_that_points_outside_is_damage(whole: bytes, tmp_path: Path) -> None:
    """Without the summary's checksum nothing but the place itself tells."""
    path = tmp_path / "bag.mcap"
    start = struct.unpack_from("<Q", whole, len(whole) - len(MAGIC) - 20)[0]
    summary = mcap_parsing.records(memoryview(whole), start, len(whole) - len(MAGIC) - 29)
    place = next(offset for op, offset, _ in summary if op == Op.CHUNK_INDEX) + 9 + 16
    for wrong in (len(whole), 2**63, 2**64 - 1, start, 0, 100):
        data = bytearray(whole)
        data[-12:-8] = bytes(4)
        struct.pack_into("<Q", data, place, wrong)
        path.write_bytes(data)
        offered, problems = read(path)
        assert offered == RAWS
        assert problems
        with pytest.raises(BagError):
            Bag(path)


def bomb(compression: str, packed: bytes, size: int, *, cut: bool = False) -> bytes:
    """Return a file with one chunk that says it unpacks to ``size`` bytes."""
    chunk = mcap_records.chunk(0, 1, size, 0, compression, packed)
    return MAGIC + mcap_records.header("bomb") + (chunk[:-10] if cut else chunk)


UNPACKED = 4 << 30
BOMBS: dict[str, Callable[[bytes, bytes], bytes]] = {
    "zstd that says little": lambda zeros, _: bomb("zstd", zeros, 1000),
    "zstd that says all": lambda zeros, _: bomb("zstd", zeros, UNPACKED),
    "zstd cut": lambda zeros, _: bomb("zstd", zeros, UNPACKED, cut=True),
    "lz4 that says little": lambda _, zeros: bomb("lz4", zeros, 1000),
    "lz4 that says all": lambda _, zeros: bomb("lz4", zeros, UNPACKED),
    "lz4 cut": lambda _, zeros: bomb("lz4", zeros, UNPACKED, cut=True),
}
READ = """
import resource, sys
from pathlib import Path
from hslam_bags.info import info
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
for path in sys.argv[1:]:
    print(info(Path(path), thorough=True).problems[-1])
"""


def test_what_would_unpack_to_gigabytes_is_refused(tmp_path: Path) -> None:
    """Each in a process that may not take more than 3 GB, of which Python and its libraries map one."""
    packer = zstd.ZstdCompressor()
    piece = bytes(64 << 20)
    zeros = b"".join([packer.compress(piece) for _ in range(UNPACKED // len(piece))]) + packer.flush()
    frame = lz4.frame.LZ4FrameCompressor()
    lz4_zeros = frame.begin() + frame.compress(bytes(700 << 20)) + frame.flush()
    assert len(zeros) < 1 << 20
    paths = []
    for number, make in enumerate(BOMBS.values()):
        paths.append(tmp_path / f"{number}.mcap")
        paths[-1].write_bytes(make(zeros, lz4_zeros))
    run = subprocess.run([sys.executable, "-c", READ, *paths], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    lines = run.stdout.splitlines()
    assert len(lines) == len(BOMBS)
    for name, line in zip(BOMBS, lines, strict=True):
        expected = {
            "little": "unpacks to more bytes where 1000 should be",
            "all": f"the most that is taken is {LARGEST}",
        }
        assert expected.get(name.split()[-1], "a record of") in line


@pytest.mark.parametrize("compression", ["zstd", "lz4", ""])
def test_unpacking_gives_what_was_packed_and_nothing_else(compression: str) -> None:
    data = b"abc" * 1000
    packed = {"zstd": zstd.compress(data), "lz4": lz4.frame.compress(data), "": data}[compression]
    assert unpack(compression, packed, len(data)) == data
    for size in (len(data) - 1, len(data) + 1):
        with pytest.raises(ValueError, match=r"unpacks to (more|3000) bytes where"):
            unpack(compression, packed, size)
    with pytest.raises(ValueError, match="is packed by 'rar', which is unknown"):
        unpack("rar", packed, len(data))


def test_a_file_s_span_is_that_of_all_its_chunks(bag: Path, definitions: DefinitionSource) -> None:
    """Neither the first nor the last chunk need hold the first or last time."""
    times = [5, 6, 9, 1, 7, 7, 3, 4]
    with Recorder(bag, RecorderConfig(chunk_kb=1), definitions=definitions) as recorder:
        for stamp_ns in times:
            recorder.write("/chatter", STRING, string_cdr(f"{stamp_ns} " + "x" * 1000), stamp_ns)
    with Bag(bag) as opened:
        assert opened.span_ns == (1, 9)
        assert [message.log_ns for message in opened.messages()] == sorted(times)
    assert "nanoseconds_since_epoch: 1\n" in (bag / "metadata.yaml").read_text()
    assert "nanoseconds: 8\n" in (bag / "metadata.yaml").read_text()
    data = (bag / "bag_0.mcap").read_bytes()
    assert zlib.crc32(data[:-12]) != 0
    (bag / "bag_0.mcap").write_bytes(data[:-1])  # without the summary the chunks themselves tell
    with Bag(bag, tolerant=True) as opened:
        assert opened.span_ns == (1, 9)


def test_messages_of_one_time_keep_the_order_of_chunks_and_within_them(
    bag: Path, definitions: DefinitionSource
) -> None:
    raws = [string_cdr(f"{index} " + "x" * 400) for index in range(40)]
    with Recorder(bag, RecorderConfig(chunk_kb=1), definitions=definitions) as recorder:
        for raw in raws:
            recorder.write("/chatter", STRING, raw, 7)
    assert len(chunks((bag / "bag_0.mcap").read_bytes())) > 10
    with Bag(bag) as opened:
        assert [message.raw for message in opened.messages()] == raws
        assert [message.raw for message in opened.messages(start_ns=7, end_ns=8)] == raws
        assert not list(opened.messages(start_ns=8))
