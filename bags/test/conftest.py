"""What the tests of bags share: definitions written out here, so that they need no installed ROS."""

from pathlib import Path

import pytest

from hslam_bags.definitions import DefinitionSource

TIME = "int32 sec\nuint32 nanosec\n"
HEADER = "# stamped\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
VECTOR = "float64 x\nfloat64 y\nfloat64 z\n"
STAMPED = "std_msgs/Header header\nVector3 vector  # in the header's frame\n"
TEXT = "uint8 LIMIT=3\nstring<=20 data\n"


@pytest.fixture(scope="session")
def definitions(tmp_path_factory: pytest.TempPathFactory) -> DefinitionSource:
    """Return a source that knows a few standard types, as an installed prefix has them."""
    prefix = tmp_path_factory.mktemp("prefix")
    for package, name, text in (
        ("builtin_interfaces", "Time", TIME),
        ("std_msgs", "Header", HEADER),
        ("std_msgs", "String", "string data\n"),
        ("geometry_msgs", "Vector3", VECTOR),
        ("geometry_msgs", "Vector3Stamped", STAMPED),
        ("example_msgs", "Text", TEXT),
    ):
        folder = prefix / "share" / package / "msg"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.msg").write_text(text)
    hashes = '{"type_hashes": [{"type_name": "std_msgs/msg/String", "hash_string": "RIHS01_0123"}]}'
    (prefix / "share/std_msgs/msg/String.json").write_text(hashes)
    return DefinitionSource([prefix])


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """Return where a test writes its bag."""
    return tmp_path / "bag"
