"""Installs hslam_atlas where `ros2 run` and `ros2 launch` look for it."""

from glob import glob

from setuptools import find_packages, setup

setup(
    name="hslam_atlas",
    version="0.1.0",
    packages=find_packages(include=["hslam_atlas", "hslam_atlas.*"]),
    package_data={"hslam_atlas": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_atlas"]),
        ("share/hslam_atlas", ["package.xml"]),
        ("share/hslam_atlas/launch", glob("launch/*.launch.py")),
        ("share/hslam_atlas/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Edge-maps to an atlas: matching, loop closing, optimisation, planning, exploration.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["atlas_node = hslam_atlas.executables:atlas_node"]},
)
