"""A grid of square cells whose content is built when first asked for; the last few are kept."""

from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, TypeVar

CELL_M = 1.0
CELL_RADIUS_M = 0.7072 * CELL_M
"""Farthest any point of a cell lies from its centre."""
CELLS_KEPT = 64

Content = TypeVar("Content")


class Cells(Generic[Content]):
    """What lies around each cell, so that a huge world costs no more per step than a corridor."""

    def __init__(self, build: Callable[[float, float], Content]) -> None:
        """Take the function that gathers the content around a cell's centre (m)."""
        self._build = build
        self._kept: OrderedDict[tuple[int, int], Content] = OrderedDict()

    def around(self, x: float, y: float) -> Content:
        """Return the content of the cell a point (m) lies in."""
        key = (int(x // CELL_M), int(y // CELL_M))
        content = self._kept.get(key)
        if content is None:
            content = self._build((key[0] + 0.5) * CELL_M, (key[1] + 0.5) * CELL_M)
            self._kept[key] = content
            if len(self._kept) > CELLS_KEPT:
                self._kept.popitem(last=False)
        return content
