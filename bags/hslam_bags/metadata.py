"""The metadata.yaml of a rosbag2 directory, version 9 (Jazzy)."""

import math
import textwrap
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import yaml

from hslam_bags.errors import BagError
from hslam_bags.qos import OfferedQos, qos_to_yaml

FILE_NAME = "metadata.yaml"


class TopicInfo(NamedTuple):
    """What a bag knows of a topic."""

    name: str
    type_name: str
    offers: tuple[OfferedQos, ...]
    type_hash: str
    message_count: int


class FileInfo(NamedTuple):
    """One file of a bag; ``span_ns`` is the first and last log time, None if it holds no message."""

    name: str
    span_ns: tuple[int, int] | None
    message_count: int


class Metadata(NamedTuple):
    """A bag as a whole, in the order its topics and files were added."""

    topics: tuple[TopicInfo, ...]
    files: tuple[FileInfo, ...]
    custom: Mapping[str, str]
    storage: str = "mcap"

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """First and last log time over all files, None if there is no message."""
        spans = [file.span_ns for file in self.files if file.span_ns]
        return (min(span[0] for span in spans), max(span[1] for span in spans)) if spans else None

    @property
    def message_count(self) -> int:
        """Messages over all files."""
        return sum(file.message_count for file in self.files)


def to_yaml(metadata: Metadata) -> str:
    """Return the text of metadata.yaml.

    A YAML library would cost a step's time at every chunk; so it writes the strings, once each, and the rest, words and
    numbers known here, is put around them by hand.
    """
    lines = [
        "rosbag2_bagfile_information:",
        "  version: 9",
        f"  storage_identifier: {metadata.storage}",
        *_span(metadata.span_ns, "  "),
        f"  message_count: {metadata.message_count}",
        "  topics_with_message_count:" + ("" if metadata.topics else " []"),
    ]
    for topic in metadata.topics:
        lines += [
            "    - topic_metadata:",
            f"        name: {_scalar(topic.name)}",
            f"        type: {_scalar(topic.type_name)}",
            "        serialization_format: cdr",
            "        offered_qos_profiles:" + ("" if topic.offers else " []"),
            *([qos_to_yaml(topic.offers, " " * 10)] if topic.offers else []),
            f"        type_description_hash: {_scalar(topic.type_hash)}",
            f"      message_count: {topic.message_count}",
        ]
    lines += ['  compression_format: ""', '  compression_mode: ""', "  relative_file_paths:"]
    lines += [f"    - {_scalar(file.name)}" for file in metadata.files]
    lines += ["  files:"]
    for file in metadata.files:
        lines += [f"    - path: {_scalar(file.name)}", *_span(file.span_ns, "      ")]
        lines += [f"      message_count: {file.message_count}"]
    lines += ["  custom_data:" + ("" if metadata.custom else " ~")]
    lines += [f"    {_scalar(key)}: {_scalar(value)}" for key, value in metadata.custom.items()]
    return "\n".join([*lines, "  ros_distro: jazzy", ""])


def to_record(metadata: Metadata) -> str:
    """Return what an MCAP file's own metadata record holds: the same, without the key around it."""
    return textwrap.dedent(to_yaml(metadata).partition("\n")[2])


@lru_cache(maxsize=1024)
def _scalar(text: str) -> str:
    """Return a string as YAML has it, in quotes and on one line."""
    return yaml.safe_dump(text, default_style='"', width=math.inf).rstrip("\n")


def _span(span_ns: tuple[int, int] | None, indent: str) -> tuple[str, ...]:
    """Return the YAML lines of a span of time."""
    start, end = span_ns or (0, 0)
    return (
        f"{indent}duration:",
        f"{indent}  nanoseconds: {end - start}",
        f"{indent}starting_time:",
        f"{indent}  nanoseconds_since_epoch: {start}",
    )


def write_metadata(directory: Path, metadata: Metadata) -> None:
    """Replace the directory's metadata.yaml at one stroke, so that none sees half of it; BagError if that fails."""
    path = directory / FILE_NAME
    fresh = directory / (FILE_NAME + ".new")
    try:
        fresh.write_text(to_yaml(metadata), encoding="utf-8")
        fresh.replace(path)
    except OSError as error:
        fresh.unlink(missing_ok=True)
        raise BagError(path, "", f"{(error.strerror or 'write failed').lower()}; the former version stays") from error
