"""What a person is told of the noise the filter goes by: where odometry's comes from, and whether what is seen fits."""

from hslam_ekf.innovation_check import InnovationCheck
from hslam_ekf.odometry_noise import NoiseSource, OdometryNoise


class NoiseReport:
    """Tells of each source once, and of a misfit each time it begins."""

    def __init__(self) -> None:
        """Begin with nothing told."""
        self._told = {NoiseSource.NOT_YET}
        self._misfit = False

    def news(self, noise: OdometryNoise, innovations: InnovationCheck) -> list[str]:
        """Return what has not been told yet, a line each."""
        lines = []
        if noise.source not in self._told:
            self._told.add(noise.source)
            lines.append(_source(noise))
        misfit = bool(innovations.finding)
        if misfit and not self._misfit:
            lines.append(innovations.finding)
        self._misfit = misfit
        return lines


def standing(noise: OdometryNoise, innovations: InnovationCheck) -> list[str]:
    """Return how things stand, a clause each; nothing before the first step."""
    source = [] if noise.source is NoiseSource.NOT_YET else [_source(noise)]
    return source + [innovations.finding] * bool(innovations.finding)


def _source(noise: OdometryNoise) -> str:
    because = f" ({noise.reason})" if noise.reason else ""
    return f"odometry is weighed by {noise.source.value}{because}"
