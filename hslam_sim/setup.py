"""Installs hslam_sim where `ros2 run` and `ros2 launch` look for it."""

from glob import glob

from setuptools import find_packages, setup

setup(
    name="hslam_sim",
    version="0.1.0",
    packages=find_packages(include=["hslam_sim", "hslam_sim.*"]),
    package_data={"hslam_sim": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_sim"]),
        ("share/hslam_sim", ["package.xml"]),
        ("share/hslam_sim/launch", glob("launch/*.launch.py")),
        ("share/hslam_sim/config", glob("config/*.yaml")),
        ("share/hslam_sim/worlds", glob("worlds/*")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Worlds, the Scout base, its sonar and landmarks, and the truth to score against.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["sim_node = hslam_sim.executables:sim_node"]},
)
