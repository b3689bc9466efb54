"""The parameters of the nodes of a run, so that a slip in a setting is told before anything is started or replaced."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from hslam_atlas.atlas_node import AtlasNodeConfig
from hslam_atlas.config import AtlasConfig
from hslam_bringup.run_options import SET_BY_THE_RUN
from hslam_ekf.config import EkfConfig
from hslam_ekf.ekf_node import EkfNodeConfig
from hslam_gvg.gvg_node import GvgNodeConfig
from hslam_gvg.level import CONFIGURATIONS, SourceConfig
from hslam_landmarks.config import ScanLandmarksConfig, ScannerConfig
from hslam_landmarks.scan_landmarks_node import LinkConfig
from hslam_sim.landmark_sensor import LandmarkConfiguration
from hslam_sim.run_configuration import RunConfiguration
from hslam_sim.simulation import SimulationConfiguration
from hslam_types.config import Configuration, Parameter, check
from hslam_types.errors import ConfigurationError
from scout_driver import scout_emulator
from scout_driver.config import DriverConfig, NodeConfig
from scout_driver.emulator.config import EmulatorConfig, FaultConfig

Grouped = tuple[tuple[str, type[Configuration]], ...]
"""Configurations, each with the prefix of its parameters' names."""

_SIMULATED = SimulationConfiguration()

ALGORITHMS: Mapping[str, Grouped] = {
    "sim": tuple((f"{part.name}.", type(getattr(_SIMULATED, part.name))) for part in fields(_SIMULATED)),
    "gvg": (("", SourceConfig),),
    "scan_landmarks": (("", ScannerConfig), ("", ScanLandmarksConfig)),
    "ekf": (("", EkfConfig),),
    "atlas": (("", AtlasConfig),),
}
"""By node: what it does, in one process too; the GVG level has besides what its source asks for."""

NODES: Mapping[str, Grouped] = {
    "sim": (*ALGORITHMS["sim"], ("", RunConfiguration)),
    "gvg": (*ALGORITHMS["gvg"], ("", GvgNodeConfig)),
    "scan_landmarks": (*ALGORITHMS["scan_landmarks"], ("", LinkConfig)),
    "ekf": (*ALGORITHMS["ekf"], ("", EkfNodeConfig)),
    "atlas": (*ALGORITHMS["atlas"], ("", AtlasNodeConfig)),
    "scout": (("", DriverConfig), ("", NodeConfig)),
    "scout_emulator": (
        ("", scout_emulator.RunConfiguration),
        ("base.", EmulatorConfig),
        ("faults.", FaultConfig),
        ("landmarks.", LandmarkConfiguration),
    ),
}
"""By node: what it does and how it is joined to the others, as a process of its own."""


def check_settings(settings: Mapping[str, Mapping[str, Any]], nodes: Mapping[str, Grouped]) -> None:
    """Raise ConfigurationError where a setting, by node and name, is of no parameter, of the wrong type or range."""
    for node, values in settings.items():
        known = {entry.name: entry for entry in parameters(groups_of(node, nodes, values))}
        for name, value in values.items():
            if name not in known:
                names = ", ".join(sorted(known.keys() - SET_BY_THE_RUN))
                raise ConfigurationError(f"{node} has no parameter '{name}' here; it has: {names}")
            check(known[name], value)


def groups_of(node: str, nodes: Mapping[str, Grouped], values: Mapping[str, Any]) -> Grouped:
    """Return the configurations of a node that is set to ``values``; raises ConfigurationError on an unknown source."""
    if node != "gvg":
        return nodes[node]
    source = SourceConfig(
        **{entry.name: values[entry.name] for entry in SourceConfig.parameters() if entry.name in values}
    )
    return (*nodes[node], *CONFIGURATIONS[source.level])


def parameters(groups: Grouped) -> Iterator[Parameter]:
    """Yield the parameters of a node under their full names."""
    for prefix, configuration in groups:
        for entry in configuration.parameters():
            yield entry._replace(name=prefix + entry.name)
