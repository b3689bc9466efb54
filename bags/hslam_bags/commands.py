"""What the `hslam` command calls: `record` and `replay` run the nodes in this process; the others use no ROS."""

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from hslam_bags.info import info
from hslam_bags.record_configuration import RecordConfiguration
from hslam_bags.repair import repair
from hslam_bags.replay_configuration import ReplayConfiguration

__all__ = ["info", "parameter_arguments", "record", "repair", "replay"]

Setting = bool | int | float | str


def record(
    path: Path,
    topics: Sequence[str] = (),
    exclude: Sequence[str] = (),
    settings: Mapping[str, Setting] | None = None,
) -> None:
    """Record to a new bag at ``path`` until Ctrl-C; ends the process with the node's exit status.

    ``exclude`` is left out besides what always is; ``settings`` are parameters of `record_node` by name.
    """
    from hslam_bags.record_node import main  # noqa: PLC0415  (ROS takes half a second to import)

    _run(main, _choice(path, topics, (RecordConfiguration().exclude, *exclude)) | dict(settings or {}))


def replay(
    path: Path,
    topics: Sequence[str] = (),
    exclude: Sequence[str] = (),
    settings: Mapping[str, Setting] | None = None,
) -> None:
    """Replay the bag at ``path`` to its end; ends the process with the node's exit status.

    ``exclude`` is left out besides what always is; ``settings`` are parameters of `replay_node` by name: rate,
    lockstep, live, start_s, paused ...
    """
    from hslam_bags.replay_node import main  # noqa: PLC0415  (as above)

    _run(main, _choice(path, topics, (ReplayConfiguration().exclude, *exclude)) | dict(settings or {}))


def parameter_arguments(settings: Mapping[str, Setting]) -> list[str]:
    """Return the command line that gives a node these parameters; strings are quoted, or "1" would be a number."""
    arguments = ["--ros-args"]
    for name, value in settings.items():
        arguments += ["-p", f"{name}:={json.dumps(value)}"]
    return arguments


def _choice(path: Path, topics: Sequence[str], exclude: Sequence[str]) -> dict[str, Setting]:
    return {"path": str(path), "topics": ",".join(topics), "exclude": ",".join(exclude)}


def _run(main: Callable[[], None], settings: Mapping[str, Setting]) -> None:
    sys.argv = [sys.argv[0], *parameter_arguments(settings)]
    main()
