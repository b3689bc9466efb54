"""Installs hslam_bags where ament and `ros2 run` look for it."""

from setuptools import setup

setup(
    name="hslam_bags",
    version="0.1.0",
    packages=["hslam_bags"],
    package_data={"hslam_bags": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_bags"]),
        ("share/hslam_bags", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "mcap", "mcap-ros2-support"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Records runs to rosbag2 directories of MCAP files, and reads, repairs and replays them.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "record_node = hslam_bags.executables:record_node",
            "replay_node = hslam_bags.executables:replay_node",
        ]
    },
)
