"""Installs hslam_gvg where `ros2 run` and `ros2 launch` look for it."""

from glob import glob

from setuptools import find_packages, setup

setup(
    name="hslam_gvg",
    version="0.1.0",
    packages=find_packages(include=["hslam_gvg", "hslam_gvg.*"]),
    package_data={"hslam_gvg": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_gvg"]),
        ("share/hslam_gvg", ["package.xml"]),
        ("share/hslam_gvg/launch", glob("launch/*.launch.py")),
        ("share/hslam_gvg/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Sonar to local obstacle map to control along the generalized Voronoi graph.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["gvg_node = hslam_gvg.executables:gvg_node"]},
)
