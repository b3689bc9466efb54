"""Installs scout_driver where `ros2 run` and `ros2 launch` look for it."""

from glob import glob

from setuptools import find_packages, setup

setup(
    name="scout_driver",
    version="0.1.0",
    packages=find_packages(include=["scout_driver", "scout_driver.*"]),
    package_data={"scout_driver": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/scout_driver"]),
        ("share/scout_driver", ["package.xml"]),
        ("share/scout_driver/launch", glob("launch/*.launch.py")),
        ("share/scout_driver/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="The serial line of a Nomadic Scout to and from the topics of the suite, and an emulator of the base.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "scout_node = scout_driver.executables:scout_node",
            "scout_emulator = scout_driver.executables:scout_emulator",
            "scout_calibrate = scout_driver.executables:scout_calibrate",
        ]
    },
)
