"""What a person sees while a robot explores."""

import time
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Where an exploration stands."""

    sim_time_s: float
    nodes: int
    edges: int
    unexplored: int
    """Branches that nobody has driven along yet."""
    path_length_m: float


class ExplorationProgress:
    """A live line: nodes, open edges, metres, real-time factor and the time left, as far as it can be told."""

    def __init__(self, console: Console) -> None:
        """The display goes to ``console``; off a terminal it prints nothing until the end."""
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(bar_width=20),
            TextColumn("{task.fields[figures]}"),
            TimeElapsedColumn(),
            console=console,
        )
        self._task = self._progress.add_task("exploring", total=None, figures="starting the nodes")
        self._start_s = time.monotonic()
        self.wall_time_s = 0.0

    def __enter__(self) -> Self:
        """Start the display."""
        self._progress.start()
        self._start_s = time.monotonic()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the display."""
        self.wall_time_s = time.monotonic() - self._start_s
        self._progress.stop()

    def show(self, now: Snapshot) -> None:
        """Redraw with the newest figures."""
        wall_s = max(time.monotonic() - self._start_s, 1e-3)
        total = now.edges + now.unexplored
        left = f"~{wall_s * now.unexplored / now.edges:.0f} s left" if now.edges else "time left unknown"
        figures = (
            f"{now.nodes} nodes, {now.edges} edges, {now.unexplored} open | {now.path_length_m:.0f} m | "
            f"{now.sim_time_s / wall_s:.0f}x real time | {left}"
        )
        self._progress.update(self._task, total=total or None, completed=now.edges, figures=figures)
