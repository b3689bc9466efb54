"""Recording raw serialised messages into a rosbag2 directory of MCAP files.

One object for the record node and for a run in one process; it holds no clock, so what it writes depends on what
it is given alone. Message times are given in integer nanoseconds.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from hslam_bags.definitions import Definition, DefinitionSource
from hslam_bags.errors import BagError
from hslam_bags.mcap_file import McapFile
from hslam_bags.metadata import FileInfo, Metadata, TopicInfo, to_record, write_metadata
from hslam_bags.qos import OfferedQos, qos_to_yaml
from hslam_types.config import Configuration, parameter
from hslam_types.errors import ConfigurationError

LATEST_NS = 2**63 - 1
"""The latest time of a message: rosbag2 counts nanoseconds in 64 bits with a sign (the year 2262)."""


@dataclass(frozen=True)
class RecorderConfig(Configuration):
    """How a bag is laid out."""

    chunk_kb: int = parameter(1024, "a chunk is packed and written at this size", low=1, high=1 << 18, unit="KiB")
    compression: str = parameter("zstd", "packing of chunks: zstd or none")
    split_mb: int = parameter(256, "a new file begins at this size; 0: never", low=0, unit="MiB")
    split_s: float = parameter(
        0.0, "a new file begins when one spans this much recorded time; 0: never", low=0, unit="s"
    )

    def __post_init__(self) -> None:
        """Check the values; raises ConfigurationError."""
        super().__post_init__()
        if self.compression not in ("zstd", "none"):
            raise ConfigurationError(f"parameter 'compression' = {self.compression!r} is neither zstd nor none")


@dataclass
class _Topic:
    """A recorded topic, and its channel in the present file."""

    name: str
    definition: Definition
    offers: tuple[OfferedQos, ...]
    count: int = 0
    channel: int = 0


class Recorder:
    """Writes one bag; use it as a context manager, or call `close`."""

    def __init__(
        self,
        directory: Path,
        config: RecorderConfig | None = None,
        *,
        definitions: DefinitionSource | None = None,
        custom: Mapping[str, str] | None = None,
    ) -> None:
        """Begin a bag in ``directory`` (new or empty, else BagError); ``custom`` is kept in its metadata."""
        self.directory = directory
        self._config = config or RecorderConfig()
        self._definitions = definitions or DefinitionSource()
        self._custom = dict(custom or {})
        self._topics: dict[str, _Topic] = {}
        self._schemas: dict[str, int] = {}
        self._done: dict[str, FileInfo] = {}
        self._failure: BagError | None = None
        self._cause: BagError | None = None
        self._split_bytes = self._config.split_mb << 20 or 1 << 62
        self._split_ns = round(self._config.split_s * 1e9) or 1 << 62
        self._first_ns = -1
        self._file_full = False
        try:
            directory.mkdir(parents=True, exist_ok=True)
            if any(directory.iterdir()):
                raise BagError(directory, "", "exists already and is not empty; nothing is overwritten")
        except OSError as error:
            raise BagError(directory, "", f"cannot be created: {error.strerror}") from error
        self._file: McapFile | None = self._open()
        self._write_metadata()

    def __enter__(self) -> Self:
        """Return the recorder itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the bag whole, whatever ended the block."""
        self.close()

    @property
    def cause(self) -> BagError | None:
        """Why recording ended early: what the bag could not be written for."""
        return self._cause

    @property
    def message_count(self) -> int:
        """Messages given so far, the last chunk's included."""
        return sum(topic.count for topic in self._topics.values())

    def add_topic(self, topic: str, type_name: str, offers: tuple[OfferedQos, ...] = (OfferedQos(),)) -> Definition:
        """Make a topic known before its first message, with the QoS a replay shall offer.

        Raises BagError if the type's definition is not installed or the topic has another type already.
        """
        known = self._topics.get(topic)
        if known is None:
            try:
                definition = self._definitions.find(type_name)
            except LookupError as error:
                raise BagError(self.directory, f"topic {topic}", str(error)) from error
            known = _Topic(topic, definition, offers)
            if self._file is not None:
                self._register(self._file, known)
            self._topics[topic] = known
        elif known.definition.name != type_name:
            raise BagError(self.directory, f"topic {topic}", f"is of type {known.definition.name}, not {type_name}")
        return known.definition

    def write(self, topic: str, type_name: str, raw: bytes, stamp_ns: int, publish_ns: int | None = None) -> None:
        """Record one message: its CDR bytes, when it was received and, if that differs, published (ns).

        Raises BagError when the disk is full; the bag stays readable up to then, and takes no more.
        """
        known = self._topics.get(topic)
        if known is None or known.definition.name != type_name:
            self.add_topic(topic, type_name)
            known = self._topics[topic]
        file = self._file
        if file is None:
            raise self._failure or BagError(self.directory, "", "is closed already")
        publish_ns = stamp_ns if publish_ns is None else publish_ns
        if not (0 <= stamp_ns <= LATEST_NS and 0 <= publish_ns <= LATEST_NS):
            problem = f"a message has the time {stamp_ns} ns, published {publish_ns} ns, which no bag can hold"
            raise BagError(self.directory, f"topic {topic}", problem)
        if self._first_ns < 0:
            self._first_ns = stamp_ns
        if self._file_full or stamp_ns - self._first_ns >= self._split_ns:
            file = self._split()
            self._first_ns = stamp_ns
        try:
            ended = file.write(known.channel, stamp_ns, publish_ns, raw)
        except BagError as error:
            raise self._fail(error) from error
        known.count += 1
        if ended:
            self._file_full = file.size >= self._split_bytes
            self._write_metadata()

    def flush(self) -> None:
        """Bring everything given so far to disk; BagError if the disk is full."""
        if self._file is not None:
            try:
                self._file.flush()
            except BagError as error:
                raise self._fail(error) from error
            self._write_metadata()

    def close(self) -> None:
        """Write what is left and end the bag; calling again does nothing. BagError if the disk is full."""
        file, self._file = self._file, None
        if file is not None:
            try:
                file.flush()
                self._done[file.path.name] = _file_info(file)
                file.close({"serialized_metadata": to_record(self.metadata())})
                self._write_metadata()
            except BagError as error:
                raise self._fail(error, file) from error

    def metadata(self) -> Metadata:
        """Return what the bag holds on disk."""
        files = [*self._done.values(), *([_file_info(self._file)] if self._file else [])]
        pending = self._file.pending if self._file else {}
        topics = (
            TopicInfo(
                topic.name,
                topic.definition.name,
                topic.offers,
                topic.definition.type_hash,
                topic.count - pending.get(topic.channel, 0),
            )
            for topic in self._topics.values()
        )
        return Metadata(tuple(topics), tuple(files), self._custom)

    def _open(self) -> McapFile:
        """Begin the next file, with every topic known so far."""
        path = self.directory / f"{self.directory.resolve().name}_{len(self._done)}.mcap"
        compression = "" if self._config.compression == "none" else self._config.compression
        file = McapFile(path, chunk_bytes=self._config.chunk_kb << 10, compression=compression)
        self._schemas.clear()
        for topic in self._topics.values():
            self._register(file, topic)
        return file

    def _register(self, file: McapFile, topic: _Topic) -> None:
        """Give a topic its schema and channel in ``file``."""
        definition = topic.definition
        if definition.name not in self._schemas:
            self._schemas[definition.name] = file.add_schema(definition.name, definition.encoding, definition.text)
        about = {"offered_qos_profiles": qos_to_yaml(topic.offers), "topic_type_hash": definition.type_hash}
        topic.channel = file.add_channel(topic.name, self._schemas[definition.name], about)

    def _split(self) -> McapFile:
        """End the present file and begin the next."""
        self.close()
        self._file_full = False
        try:
            self._file = self._open()
        except BagError as error:
            raise self._fail(error) from error
        self._write_metadata()
        return self._file

    def _fail(self, error: BagError, file: McapFile | None = None) -> BagError:
        """Stop recording for good and return the one line that says so."""
        file, self._file = file or self._file, None
        if file is not None:
            file.abandon()
            self._done[file.path.name] = _file_info(file)
        kept = sum(info.message_count for info in self._done.values())
        problem = f"{error.problem}; recording stops, the {kept} messages written before stay readable"
        self._cause, self._failure = error, BagError(error.path, error.place, problem)
        return self._failure

    def _write_metadata(self) -> None:
        """Bring metadata.yaml up to date."""
        try:
            write_metadata(self.directory, self.metadata())
        except BagError as error:
            raise self._fail(error) from error


def _file_info(file: McapFile) -> FileInfo:
    """Describe a file for the metadata."""
    return FileInfo(file.path.name, file.span_ns, file.message_count)
