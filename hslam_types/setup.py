"""Installs hslam_types where `ros2 run` and `ros2 launch` look for it."""

from setuptools import find_packages, setup

setup(
    name="hslam_types",
    version="0.1.0",
    packages=find_packages(include=["hslam_types", "hslam_types.*"]),
    package_data={"hslam_types": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_types"]),
        ("share/hslam_types", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Values that cross package borders: poses, readings, GVG events, edge-maps, configuration.",
    license="Apache-2.0",
)
