"""What one step of the simulator costs: `python bench/simulation_step.py [WORLD ...] [--steps N]`.

The robot wanders by what it hears, so that the figure is that of driving, not of leaning on a wall.
CPU time of this process is counted, which a busy machine does not inflate.
"""

import argparse
import math
import time

from hslam_sim.simulation import SimStep, Simulation
from hslam_sim.worlds import load_world
from hslam_types.sensing import Velocity

FRONT = (0, 1, 15)
CLEAR_M = 0.8


def wander(heard: dict[int, float], step: SimStep) -> Velocity:
    """Return a command that goes straight while the front sonars are clear and turns left otherwise."""
    heard.update((ping.sensor, ping.range_m) for ping in step.sonar.pings)
    if min(heard.get(sensor, math.inf) for sensor in FRONT) > CLEAR_M:
        return Velocity(0.4, 0.0)
    return Velocity(0.0, 0.8)


def measure(name: str, steps: int, seed: int) -> str:
    """Drive ``steps`` steps in a world and return a line of figures."""
    simulation = Simulation(load_world(name), seed=seed)
    heard: dict[int, float] = {}
    command, spent, sightings = Velocity(), 0.0, 0
    for _ in range(steps):
        began = time.process_time()
        step = simulation.step(command)
        spent += time.process_time() - began
        command = wander(heard, step)
        sightings += len(step.landmarks.sightings) if step.landmarks else 0
    factor = simulation.config.clock.step_s * steps / spent
    return (
        f"{name}: {1e3 * spent / steps:.3f} ms a step, {factor:.0f} times real time, "
        f"{sightings / steps:.1f} sightings a step, {step.collisions} contacts"
    )


def main() -> None:
    """Print one line a world."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("worlds", nargs="*", default=["small_world", "wean_hall_6"])
    parser.add_argument("--steps", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    for name in options.worlds:
        print(measure(name, options.steps, options.seed))


if __name__ == "__main__":
    main()
