"""The simulated robot's configuration from settings that name its parts' parameters as the node does."""

import dataclasses
from collections.abc import Mapping
from typing import Any

from hslam_sim.simulation import SimulationConfiguration


def simulation_configuration(settings: Mapping[str, Any]) -> SimulationConfiguration:
    """Return the configuration for settings like ``sonar.noise_fraction``; raises ConfigurationError on a bad one."""
    parts: dict[str, dict[str, Any]] = {field.name: {} for field in dataclasses.fields(SimulationConfiguration)}
    for name, value in settings.items():
        part, _, parameter = name.partition(".")
        parts[part][parameter] = value
    defaults = SimulationConfiguration()
    return SimulationConfiguration(
        **{part: type(getattr(defaults, part)).from_mapping(values) for part, values in parts.items()}
    )
