"""The one error of this package: which file, where in it, and what is wrong."""

from pathlib import Path

from hslam_types.errors import HslamError


class BagError(HslamError):
    """A bag cannot be written or read; `path` is the file, `place` where in it (empty: the file as a whole)."""

    def __init__(self, path: Path, place: str, problem: str) -> None:
        """Keep the parts and make one line of them, whatever a library said in several."""
        problem = " ".join(problem.split())
        super().__init__(f"{path}: {place}: {problem}" if place else f"{path}: {problem}")
        self.path = path
        self.place = place
        self.problem = problem
