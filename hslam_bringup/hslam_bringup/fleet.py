"""The processes of a run: one per node, watched, and stopped in order."""

import ctypes
import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_prefix

from hslam_bringup.errors import NodeDiedError, RunError
from hslam_bringup.linear_algebra import ON_ONE_THREAD
from hslam_ros.private_domain import PrivateDomain

_PR_SET_PDEATHSIG = 1
"""From Linux' sys/prctl.h."""

_STOP_PATIENCE_S = 20.0
"""How long a node may take to close its files after SIGTERM before it is killed."""


@dataclass(frozen=True)
class NodeProcess:
    """How to start one node."""

    name: str
    package: str
    executable: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    arguments: Sequence[str] = ()
    topics: Mapping[str, str] = field(default_factory=dict)
    """By the name in the node's code: the name there is for it."""


class Fleet:
    """Starts nodes as separate processes; each writes to its own log file."""

    def __init__(self, folder: Path, domain: PrivateDomain | None = None) -> None:
        """``folder`` gets a log and a parameter file for every node; all speak in ``domain``, or as ROS is set."""
        self._folder = folder
        self._environment = ON_ONE_THREAD | dict(os.environ) | (domain.environment if domain else {})
        self._held = (domain.reservation,) if domain else ()
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self._peak_rss_mb: dict[str, float] = {}
        folder.mkdir(parents=True, exist_ok=True)

    def start(self, node: NodeProcess) -> None:
        """Start a node; raises RunError where its executable is not installed."""
        parameters = self._folder / f"{node.name}.yaml"
        parameters.write_text(yaml.safe_dump({node.name: {"ros__parameters": dict(node.parameters)}}))
        command = [str(executable(node.package, node.executable)), *node.arguments, "--ros-args"]
        command += ["-r", f"__node:={node.name}", "--params-file", str(parameters)]
        for name, there in node.topics.items():
            command += ["-r", f"{name}:={there}"]
        with self.log(node.name).open("wb") as log:
            # A session of its own: Ctrl-C in the terminal reaches the runner alone, which stops the nodes in order.
            self._running[node.name] = subprocess.Popen(
                command,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=self._environment,
                start_new_session=True,
                pass_fds=self._held,
                preexec_fn=_join_the_run,  # noqa: PLW1509 - system calls only, no lock is taken
            )

    def log(self, name: str) -> Path:
        """Return the file with what a node printed."""
        return self._folder / f"{name}.log"

    def ended(self, name: str) -> bool:
        """Return whether a node ended well; raises NodeDiedError if it, or any other node, did not."""
        for other, process in self._running.items():
            self._note_memory(other, process)
            status = process.poll()
            if status not in (None, 0) or (status == 0 and other != name):
                raise NodeDiedError(f"node '{other}' {_how(status)}: {self.last_words(other)}")
        return self._running[name].poll() == 0

    def stop(self, names: Sequence[str]) -> None:
        """End the nodes in the order given, each waited for before the next; kills one that does not end."""
        for name in names:
            process = self._running.get(name)
            if process is None:
                continue
            self._note_memory(name, process)
            if process.poll() is None:
                process.terminate()  # by SIGINT a node that still imports would print a traceback
            try:
                process.wait(_STOP_PATIENCE_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def peak_rss_mb(self) -> dict[str, float]:
        """Return the largest resident memory seen of each node."""
        return dict(self._peak_rss_mb)

    def last_words(self, name: str) -> str:
        """Return the last line a node printed."""
        lines = self.log(name).read_text(errors="replace").strip().splitlines()
        return f"{lines[-1]} (see {self.log(name)})" if lines else "it printed nothing"

    def _note_memory(self, name: str, process: subprocess.Popen[bytes]) -> None:
        try:
            status = Path(f"/proc/{process.pid}/status").read_text()
        except OSError:
            return
        for line in status.splitlines():
            if line.startswith("VmHWM:"):
                self._peak_rss_mb[name] = round(int(line.split()[1]) / 1024.0, 1)


def _join_the_run() -> None:
    """Ask Linux to end this process by SIGTERM when the runner dies, however that dies, and to let it finish its turns.

    In lock-step every message would wake its reader at once, in place of the node that is at work: 35 switches a step
    and cold caches. A batch process waits its turn, which costs nothing where all wait for each other anyway.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.sched_getscheduler(0) == os.SCHED_OTHER:  # else the user has chosen
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def executable(package: str, name: str) -> Path:
    """Return the path of an installed node, where `ros2 run` finds it; raises RunError if there is none."""
    try:
        path = Path(get_package_prefix(package)) / "lib" / package / name
    except PackageNotFoundError as error:
        raise RunError(
            f"package '{package}' is not installed here; run 'make setup' or source the workspace"
        ) from error
    if not path.exists():
        raise RunError(f"{path} is missing; rebuild the workspace ('make setup')")
    return path


def _how(status: int | None) -> str:
    if status is not None and status < 0:
        return f"was ended by {signal.Signals(-status).name}"
    return f"ended with exit status {status}"
