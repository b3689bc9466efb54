"""A stored bag: a rosbag2 directory of MCAP or SQLite files, or one such file alone."""

import itertools
import re
import tempfile
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from stat import S_ISDIR
from types import TracebackType
from typing import Any, NamedTuple, Self

from hslam_bags.errors import BagError
from hslam_bags.mcap_packing import unpack_file, unpack_message
from hslam_bags.mcap_storage import McapStorage
from hslam_bags.metadata import FILE_NAME
from hslam_bags.sqlite_storage import SqliteStorage
from hslam_bags.stored import Storage, StoredMessage, StoredTopic, in_time_order
from hslam_bags.topic_choice import TopicChoice
from hslam_types.yaml_text import YamlError, load_yaml

REPAIR_HINT = "what is readable: hslam bag repair"
_ENDINGS = (".mcap", ".db3", ".mcap.zstd", ".db3.zstd")
FOREVER_NS = 2**64
"""Later than any message."""


class _Listed(NamedTuple):
    """What metadata.yaml says of the files."""

    files: list[Path]
    packing: str
    custom: dict[str, str]


class Bag:
    """Reads a bag's messages in order of log time; a context manager."""

    def __init__(self, path: Path, *, tolerant: bool = False) -> None:
        """Open the bag at ``path``.

        Damage raises BagError with file and place; when ``tolerant`` it is kept in `problems` and the rest is offered.
        """
        self.path = path
        self.problems: list[BagError] = []
        self._told: set[str] = set()
        self._tolerant = tolerant
        self._scratch: tempfile.TemporaryDirectory[str] | None = None
        self._files: dict[str, Storage] = {}
        try:
            is_folder = S_ISDIR(path.stat().st_mode)
        except FileNotFoundError as error:
            raise BagError(path, "", "does not exist") from error
        except OSError as error:
            raise BagError(path, "", f"cannot be read: {error.strerror}") from error
        listed = self._listed() if is_folder else _Listed([path], "", {})
        self.custom: Mapping[str, str] = listed.custom
        self._packed = listed.packing == "message"
        for file in listed.files:
            try:
                self._files[file.name] = self._open(file)
            except BagError as error:
                self.complain(error)

    def __enter__(self) -> Self:
        """Return the bag itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the files."""
        self.close()

    @property
    def files(self) -> Mapping[str, Storage]:
        """The files that could be opened, by name."""
        return self._files

    @property
    def topics(self) -> dict[str, StoredTopic]:
        """The topics by name; where files disagree, as the first has them."""
        found: dict[str, StoredTopic] = {}
        for storage in self._files.values():
            for topic in storage.topics:
                known = found.setdefault(topic.name, topic)
                if known.type_name != topic.type_name:
                    problem = f"is of type {known.type_name} and of type {topic.type_name}, which is left out"
                    self.complain(BagError(self.path, f"topic {topic.name}", problem))
        return found

    @property
    def counts(self) -> dict[str, int]:
        """Messages by topic."""
        totals: dict[str, int] = {}
        for storage in self._files.values():
            for topic, count in storage.counts.items():
                totals[topic] = totals.get(topic, 0) + count
        return totals

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """First and last log time (ns), None if there is no message."""
        spans = [span for storage in self._files.values() if (span := storage.span_ns)]
        return (min(span[0] for span in spans), max(span[1] for span in spans)) if spans else None

    def messages(
        self, choice: TopicChoice | Collection[str] | None = None, start_ns: int = 0, end_ns: int = FOREVER_NS
    ) -> Iterator[StoredMessage]:
        """Yield the chosen topics' messages with start <= log time < end, in order of log time."""
        topics = self.topics
        names = {name for name in topics if choice is None or name in choice}
        pieces = []
        for storage in self._files.values():
            if storage.span_ns:

                def iterate(storage: Storage = storage) -> Iterator[StoredMessage]:
                    return storage.messages(names, start_ns, end_ns)

                pieces.append((storage.span_ns[0], iterate))
        found = (entry for entry in in_time_order(pieces) if entry.type_name == topics[entry.topic].type_name)
        return self._unpacked(found) if self._packed else found

    def check(self) -> None:
        """Look for damage that reading the messages does not meet."""
        for storage in self._files.values():
            storage.check()

    def close(self) -> None:
        """Close the files."""
        for storage in self._files.values():
            storage.close()
        self._files.clear()
        if self._scratch is not None:
            self._scratch.cleanup()

    def complain(self, error: BagError) -> None:
        """Keep a problem, or raise it where nothing may be missing."""
        if not self._tolerant:
            raise BagError(error.path, error.place, f"{error.problem} ({REPAIR_HINT} {self.path})") from error
        if str(error) not in self._told:  # what is read twice is met twice
            self._told.add(str(error))
            self.problems.append(error)

    def _listed(self) -> _Listed:
        """Return what metadata.yaml says; where it is missing or damaged, the files of the directory by number."""
        try:
            everything = set(self.path.iterdir())
        except OSError as error:
            raise BagError(self.path, "", f"cannot be read: {error.strerror}") from error
        present = sorted((file for file in everything if file.name.endswith(_ENDINGS)), key=_by_number)
        try:
            listed = _read_metadata(self.path)
        except BagError as error:
            self.complain(error)
            listed = _Listed([], "", {})
        for file in listed.files:
            if file not in everything:
                self.complain(BagError(file, "", f"is missing, though {FILE_NAME} lists it"))
        for file in present if listed.files else ():
            if file not in listed.files:
                self.complain(BagError(file, "", f"is not listed in {FILE_NAME}"))
        if not present:
            raise BagError(self.path, "", "holds no .mcap or .db3 file: it is no bag")
        known = [file for file in listed.files if file in everything]
        return listed._replace(files=known + [file for file in present if file not in known])

    def _unpacked(self, messages: Iterator[StoredMessage]) -> Iterator[StoredMessage]:
        """Yield messages that were packed one by one."""
        for message in messages:
            try:
                raw = unpack_message(message.raw)
            except ValueError as error:
                place = f"topic {message.topic} at {message.log_ns} ns"
                self.complain(BagError(self.path, place, f"a message {error}"))
                continue
            yield message._replace(raw=raw)

    def _open(self, file: Path) -> Storage:
        """Open one file by its name's ending; one packed as a whole is unpacked aside first."""
        if file.suffix == ".zstd":
            file = self._unpack(file)
        if file.suffix == ".mcap":
            return McapStorage(file, self.complain)
        if file.suffix == ".db3":
            return SqliteStorage(file, self.complain)
        raise BagError(file, "", "is neither .mcap nor .db3, nor a bag's directory")

    def _unpack(self, file: Path) -> Path:
        if self._scratch is None:
            self._scratch = tempfile.TemporaryDirectory()
        unpacked = Path(self._scratch.name) / file.stem
        try:
            unpack_file(file, unpacked)
        except (OSError, ValueError) as error:
            raise BagError(file, "", str(error)) from error
        return unpacked


def _read_metadata(directory: Path) -> _Listed:
    """Read metadata.yaml of any version; BagError if it is missing or is none."""
    path = directory / FILE_NAME
    try:
        content: Any = load_yaml(path.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        files = [directory / Path(name).name for name in _names(content["relative_file_paths"])]
        custom = {str(key): str(value) for key, value in (content.get("custom_data") or {}).items()}
        "".join(itertools.chain(*custom.items())).encode()  # an escape can make what no file can hold
        return _Listed(files, str(content.get("compression_mode") or "").lower(), custom)
    except FileNotFoundError as error:
        raise BagError(path, "", "is missing") from error
    except OSError as error:
        raise BagError(path, "", f"cannot be read: {error.strerror}") from error
    except YamlError as error:
        raise BagError(path, f"line {error.line}" if error.line else "", f"is not YAML: {error.problem}") from error
    except (KeyError, TypeError, AttributeError, UnicodeError) as error:
        raise BagError(path, "", f"is no rosbag2 metadata: {error!r}") from error


def _names(listed: Any) -> list[str]:
    """Return a list of names; TypeError if it is something else."""
    if not isinstance(listed, list):
        raise TypeError("relative_file_paths is no list")
    return listed


def _by_number(file: Path) -> tuple[str, int]:
    """Sort bag_2 before bag_10."""
    found = re.match(r"(.*?)(\d*)\.", file.name)
    return (found[1], int(found[2] or 0)) if found else (file.name, 0)
