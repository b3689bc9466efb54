"""Raster maps: modes, cleaning, scale, place, start, and bad files."""

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest
import shapely

from hslam_sim.world import WorldError
from hslam_sim.worlds import load_world

Pixels = npt.NDArray[np.uint8]
YAML = """image: {image}
resolution: 0.05
origin: [{origin}]
negate: {negate}
occupied_thresh: 0.65
free_thresh: 0.196
"""


def room(rows: int = 120, columns: int = 200) -> Pixels:
    """Return a walled room of 9 m x 5 m, grey (unknown) around."""
    image = np.full((rows, columns), 205, dtype=np.uint8)
    image[9:111, 9:191] = 0
    image[10:110, 10:190] = 254
    return image


def write(folder: Path, image: Pixels, *, origin: str = "0, 0, 0", negate: int = 0, extra: str = "") -> str:
    cv2.imwrite(str(folder / "map.png"), image)
    path = folder / "map.yaml"
    path.write_text(YAML.format(image="map.png", origin=origin, negate=negate) + extra, encoding="utf-8")
    return str(path)


def test_a_room_has_its_size_and_place(tmp_path: Path) -> None:
    world = load_world(write(tmp_path, room(), origin="-3.0, 2.0, 0.0"))
    assert world.free_space.bounds == pytest.approx((-3.0 + 0.5, 2.0 + 0.5, -3.0 + 9.5, 2.0 + 5.5), abs=0.03)
    # The opening rounds each corner by (4 - pi) / 4 of a square of the reach.
    assert world.free_space.area == pytest.approx(45.0, rel=0.01)


def test_the_images_last_row_is_the_lowest_y(tmp_path: Path) -> None:
    image = room()
    image[10:60, 10:100] = 0
    space = load_world(write(tmp_path, image)).free_space
    assert space.contains(shapely.Point(2.0, 1.5))
    assert not space.contains(shapely.Point(2.0, 4.5))


def test_a_turned_origin_turns_the_world(tmp_path: Path) -> None:
    space = load_world(write(tmp_path, room(), origin=f"0, 0, {np.pi / 2}")).free_space
    assert space.bounds == pytest.approx((-5.5, 0.5, -0.5, 9.5), abs=0.03)


@pytest.mark.parametrize("case", ["negate", "colour", "transparent", "sixteen_bit", "raw"])
def test_every_way_to_write_a_pixel_gives_the_same_room(tmp_path: Path, case: str) -> None:
    plain = load_world(write(tmp_path, room())).free_space
    grey = room()
    image: npt.NDArray[np.uint8] | npt.NDArray[np.uint16] = grey
    negate, extra = 0, ""
    if case == "negate":
        image, negate = 255 - grey, 1
    elif case == "colour":
        image = np.repeat(grey[:, :, None], 3, axis=2)
    elif case == "transparent":
        alpha = np.where(grey == 205, 0, 255).astype(np.uint8)
        image = np.dstack([np.full_like(grey, 254), np.full_like(grey, 254), np.full_like(grey, 254), alpha])
        image[grey == 0, :3] = 0
        extra = "mode: scale\n"
    elif case == "sixteen_bit":
        image = grey.astype(np.uint16) * 257
    else:
        image = np.where(grey == 254, 0, np.where(grey == 0, 100, 255)).astype(np.uint8)
        extra = "mode: raw\n"
    other = load_world(write(tmp_path, image, negate=negate, extra=extra)).free_space  # type: ignore[arg-type]
    assert other.equals(plain)


def test_rays_cracks_and_specks_go_but_pillars_stay(tmp_path: Path) -> None:
    image = room()
    image[0:10, 50:53] = 254
    image[60:62, 60:62] = 0
    image[80:90, 120:130] = 0
    space = load_world(write(tmp_path, image)).free_space
    assert space.bounds[3] == pytest.approx(5.5, abs=0.03)
    assert len(space.interiors) == 1
    assert shapely.Polygon(space.interiors[0]).area == pytest.approx(0.25, rel=0.15)


def test_the_start_is_never_outside_the_building(tmp_path: Path) -> None:
    image = room()
    image[image == 205] = 254
    image[:, :9] = 254
    wide = np.full((600, 600), 254, dtype=np.uint8)
    wide[200:320, 200:400] = image
    space = load_world(write(tmp_path, wide)).free_space
    assert space.area == pytest.approx(45.0, rel=0.01)


def test_rays_out_of_a_window_do_not_make_a_hall_the_outside(tmp_path: Path) -> None:
    """A hall with a ray as wide as the robot to the border, and a closet of a twentieth of its size."""
    image = np.full((240, 300), 205, dtype=np.uint8)
    image[20:180, 20:280] = 254
    image[0:20, 100:112] = 254
    image[195:235, 20:72] = 254
    space = load_world(write(tmp_path, image)).free_space
    assert space.area > 100.0


def test_a_given_start_chooses_the_room(tmp_path: Path) -> None:
    two = np.hstack([room(), room(120, 200)[:, :150]])
    world = load_world(write(tmp_path, two, extra="start: {x: 14.0, y: 3.0, heading_deg: 180}\n"))
    assert world.free_space.bounds[0] > 10.0
    assert (world.start.x, world.start.y) == (14.0, 3.0)
    with pytest.raises(WorldError, match="to the next obstacle"):
        load_world(write(tmp_path, two, extra="start: {x: 0.1, y: 3.0, heading_deg: 0}\n"))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("map.png", "other.png"), "does not exist"),
        (("resolution: 0.05\n", ""), "'resolution' is missing"),
        (("0.05", "fine"), "resolution must be a number"),
        (("negate: 0\n", "negate: 0\nstarts: {}\n"), "unknown key 'starts'"),
    ],
)
def test_a_broken_map_is_named_in_one_line(tmp_path: Path, change: tuple[str, str], says: str) -> None:
    path = Path(write(tmp_path, room()))
    path.write_text(path.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    with pytest.raises(WorldError, match=says) as raised:
        load_world(str(path))
    assert "\n" not in str(raised.value)


def test_a_map_without_room_is_refused(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="no room for the robot"):
        load_world(write(tmp_path, np.zeros((50, 50), dtype=np.uint8)))
