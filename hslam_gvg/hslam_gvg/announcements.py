"""What the level announces: a traversal begins with one event and ends with one, whatever ends it."""

from typing import NamedTuple

from hslam_types.gvg_events import EventKind, GvgEvent, NodeView


class _Untold(NamedTuple):
    kind: EventKind
    node: NodeView | None = None
    branch: int = -1
    path_length_m: float = 0.0


class Announcements:
    """Collects what a step has to announce, numbers it, and knows whether a traversal is under way."""

    def __init__(self) -> None:
        """Begin with nothing announced."""
        self.traversing = False
        """Whether the last event began a traversal, which no event has ended."""
        self._sequence = 0
        self._untold: list[_Untold] = []

    @property
    def untold(self) -> bool:
        """Whether something waits for the next step to be told."""
        return bool(self._untold)

    def access(self) -> None:
        """The GVG is reached: a partial traversal begins."""
        self._add(_Untold(EventKind.ACCESS), begins=True)

    def depart(self, node: NodeView, branch: int) -> None:
        """A traversal begins at a node, by one of its branches."""
        self._add(_Untold(EventKind.DEPARTURE, node, branch), begins=True)

    def arrive(self, node: NodeView, branch: int, path_length_m: float) -> None:
        """The traversal ends at a node, come to along one of its branches (-1 if unknown)."""
        self._add(_Untold(EventKind.ARRIVAL, node, branch, path_length_m), begins=False)

    def lose(self) -> None:
        """The traversal under way, or the goal that would have led to one, is given up."""
        self._add(_Untold(EventKind.LOST), begins=False)

    def tell(self, stamp_ns: int) -> tuple[GvgEvent, ...]:
        """Return the events since the last call, as events of a cycle."""
        told = tuple(GvgEvent(self._sequence + i, stamp_ns, *untold) for i, untold in enumerate(self._untold))
        self._sequence += len(told)
        self._untold.clear()
        return told

    def _add(self, untold: _Untold, *, begins: bool) -> None:
        self._untold.append(untold)
        self.traversing = begins
