"""Whether what is seen differs from what was expected by as much as the stated noise says.

The normalised innovation squared of a consistent filter is chi-square distributed (Bar-Shalom, Li and Kirubarajan,
*Estimation with Applications to Tracking and Navigation*, 2001, section 5.4), so that its sum over a window lies
between known bounds. It is taken over the sightings that were accepted, hence never far above twice its mean
however wrong the noise is: the gate cuts off what is farther.
"""

from scipy.stats import chi2

_WINDOW = 400
"""Degrees of freedom of one window: two a sighting."""
_TAIL = 1e-3
"""Chance that a consistent filter's window lies outside the bounds, on each side."""
_TOLERATED = 1.5
"""Variances off by less than this factor are nobody's concern."""
_MOST = float(chi2.isf(_TAIL, _WINDOW)) / _WINDOW * _TOLERATED
_LEAST = float(chi2.ppf(_TAIL, _WINDOW)) / _WINDOW / _TOLERATED


class InnovationCheck:
    """Sums up corrections, window after window."""

    def __init__(self) -> None:
        """Begin the first window."""
        self._nis, self._freedom = 0.0, 0
        self.finding = ""
        """What the last whole window says against the stated noise; empty if nothing."""

    def take(self, nis: float, freedom: int) -> None:
        """Enter a correction's normalised innovation squared and its degrees of freedom."""
        self._nis += nis
        self._freedom += freedom
        if self._freedom < _WINDOW:
            return
        ratio = self._nis / self._freedom
        self._nis, self._freedom = 0.0, 0
        if ratio > _MOST:
            self.finding = "landmarks or odometry are worse than their stated deviations"
        elif ratio < _LEAST:
            self.finding = "landmarks and odometry are better than their stated deviations"
        else:
            self.finding = ""
        if self.finding:
            self.finding += f": innovations squared are {ratio:.1f} times what those allow"
