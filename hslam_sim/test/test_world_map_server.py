"""map_server files: every mode, depth and threshold means what it means to nav2_map_server, or is refused by name."""

import struct
import tracemalloc
import zlib
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from hslam_sim import map_image, raster_map
from hslam_sim.world import WorldError
from hslam_types.yaml_text import load_yaml

FIELDS = {
    "image": "map.png",
    "resolution": "0.05",
    "origin": "[0, 0, 0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}
WHITE, BLACK, UNKNOWN = 254, 0, 205


def read(folder: Path, **fields: str | None) -> raster_map.RasterMap:
    """Return the map of a YAML in ``folder`` with some fields changed, or left out if None."""
    text = "".join(f"{key}: {value}\n" for key, value in (FIELDS | fields).items() if value is not None)
    return raster_map.read(folder, load_yaml(text))


def free(folder: Path, pixels: npt.ArrayLike, **fields: str | None) -> list[bool]:
    """Return which pixels of an image of one row are free."""
    image = np.array(pixels)
    cv2.imwrite(str(folder / "map.png"), image[None].astype(np.uint16 if image.max() > 255 else np.uint8))
    (row,) = read(folder, **fields).free.tolist()
    return list(row)


def free_of_pgm(folder: Path, content: bytes, **fields: str | None) -> list[list[bool]]:
    """Return which pixels of a PGM file are free, the lowest row first."""
    (folder / "map.pgm").write_bytes(content)
    return [list(row) for row in read(folder, image="map.pgm", **fields).free.tolist()]


def test_trinary_and_scale_take_light_for_free_and_negate_takes_dark(tmp_path: Path) -> None:
    for mode in (None, "trinary", "scale"):
        assert free(tmp_path, [WHITE, UNKNOWN, 100, BLACK], mode=mode) == [True, False, False, False]
        assert free(tmp_path, [WHITE, 100, 40, BLACK], mode=mode, negate="1") == [False, False, True, True]


def test_the_free_threshold_itself_is_free(tmp_path: Path) -> None:
    assert free(tmp_path, [205, 204, 203], free_thresh="0.2") == [True, True, False]
    assert free(tmp_path, [255, 254], free_thresh="0") == [True, False]


def test_raw_is_the_occupancy_in_per_cent_whatever_negate_says(tmp_path: Path) -> None:
    for negate in ("0", "1"):
        found = free(tmp_path, [0, 19, 20, 100, 101, 205, 255], mode="raw", negate=negate)
        assert found == [True, True, False, False, False, False, False]
    assert free(tmp_path, [25, 26, 29, 30], mode="raw", free_thresh="0.29") == [True, True, True, False]


@pytest.mark.parametrize("mode", ["trinary", "scale"])
@pytest.mark.parametrize("alpha", [0, 128, 254])
def test_what_is_not_opaque_is_unknown(tmp_path: Path, mode: str, alpha: int) -> None:
    assert free(tmp_path, [[255, 255, 255, alpha], [255, 255, 255, 255]], mode=mode) == [False, True]
    assert free(tmp_path, [[0, 0, 0, alpha], [0, 0, 0, 255]], mode=mode, negate="1") == [False, True]


def test_raw_does_not_look_at_opacity(tmp_path: Path) -> None:
    assert free(tmp_path, [[0, 0, 0, 0], [255, 255, 255, 255]], mode="raw") == [True, False]


def test_colour_is_weighed_as_eyes_do(tmp_path: Path) -> None:
    """Rec. 709: green is most of the light, blue the least; OpenCV's order is blue, green, red."""
    pixels = [[255, 255, 255], [0, 255, 255], [255, 0, 255], [255, 255, 0]]
    assert free(tmp_path, pixels, free_thresh="0.5") == [True, True, False, True]
    assert free(tmp_path, pixels, free_thresh="0.1") == [True, True, False, False]


@pytest.mark.parametrize(
    ("negate", "inverted"),
    [("0", False), ("1", True), ('"0"', False), ('"1"', True), ("false", False), ('"false"', False), ("true", True),
     ("'True'", True), ('"no"', False), ("'off'", False), ("2", True)],
)  # fmt: skip
def test_negate_may_be_a_number_or_a_truth_as_text_too(tmp_path: Path, negate: str, inverted: bool) -> None:
    assert free(tmp_path, [WHITE, BLACK], negate=negate) == [not inverted, inverted]


@pytest.mark.parametrize("mode", ["Trinary", "TRINARY", "Scale", "RAW"])
def test_the_case_of_a_mode_does_not_matter(tmp_path: Path, mode: str) -> None:
    pixels = [0, 60, 100, WHITE]
    assert free(tmp_path, pixels, mode=mode) == free(tmp_path, pixels, mode=mode.lower())


@pytest.mark.parametrize(
    ("header", "values", "kind"),
    [
        (b"P5\n3 1\n1\n", [0, 1, 1], ">u1"),
        (b"P5 3 1 100 ", [0, 90, 100], ">u1"),
        (b"P5\n# by hand\n3 1 # so wide\n255\n", [0, 254, 255], ">u1"),
        (b"P5\n3 1\n1000\n", [500, 900, 1000], ">u2"),
        (b"P5\n3 1\n65535\n", [30000, 60000, 65535], ">u2"),
    ],
)
def test_the_largest_value_of_a_pgm_is_white(tmp_path: Path, header: bytes, values: list[int], kind: str) -> None:
    binary = header + np.array(values, dtype=kind).tobytes()
    plain = header.replace(b"P5", b"P2") + " ".join(map(str, values)).encode()
    for content in (binary, plain, plain + b"\n"):
        assert free_of_pgm(tmp_path, content) == [[False, True, True]]


def test_raw_greys_of_a_pgm_are_scaled_too(tmp_path: Path) -> None:
    assert free_of_pgm(tmp_path, b"P2 3 1 100 0 7 100", mode="raw") == [[True, True, False]]
    assert free_of_pgm(tmp_path, b"P2 3 1 255 0 7 100", mode="raw") == [[True, True, False]]
    assert free_of_pgm(tmp_path, b"P2 3 1 100 0 8 100", mode="raw") == [[True, False, False]], "8 of 100 is 20 of 255"


def test_deep_images_are_scaled_to_eight_bits(tmp_path: Path) -> None:
    assert free(tmp_path, [65535, 205 * 257, 0]) == [True, False, False]


def test_rows_are_turned_over_and_a_pgm_of_many_bands_is_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(map_image, "BAND", 7)
    pixels = np.random.default_rng(1).integers(0, 2, (5, 11)) * 255
    expected = (pixels[::-1] == 255).tolist()
    plain = b"P2\n11 5\n255\n" + "\n".join(" ".join(map(str, row)) for row in pixels).encode()
    assert free_of_pgm(tmp_path, plain) == expected
    assert free_of_pgm(tmp_path, b"P5\n11 5\n255\n" + pixels.astype(np.uint8).tobytes()) == expected
    deep = (pixels * 257).astype(">u2").tobytes()
    assert free_of_pgm(tmp_path, b"P5\n11 5\n65535\n" + deep) == expected
    cv2.imwrite(str(tmp_path / "map.png"), np.repeat(pixels[:, :, None], 3, axis=2).astype(np.uint8))
    assert read(tmp_path).free.tolist() == expected


@pytest.mark.parametrize("key", FIELDS)
def test_a_field_that_is_missing_is_named(tmp_path: Path, key: str) -> None:
    with pytest.raises(WorldError, match=f"'{key}' is missing"):
        free(tmp_path, [WHITE], **{key: None})


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"free_tresh": "0.25"}, "unknown key 'free_tresh'"),
        ({"free_thresh": "0.7"}, "free_thresh must be below occupied_thresh"),
        ({"free_thresh": "-0.1"}, "free_thresh must be a number from 0 to 1"),
        ({"free_thresh": ".nan"}, "free_thresh must be a number from 0 to 1"),
        ({"occupied_thresh": "1.1"}, "occupied_thresh must be a number from 0 to 1"),
        ({"occupied_thresh": "high"}, "occupied_thresh must be a number"),
        ({"negate": "maybe"}, "negate must be 0 or 1"),
        ({"negate": "0.5"}, "negate must be 0 or 1"),
        ({"negate": "[]"}, "negate must be 0 or 1"),
        ({"mode": "ternary"}, "mode must be one of trinary, scale, raw"),
        ({"mode": "1"}, "mode must be text"),
        ({"resolution": "0"}, "resolution must be a number from 0.001 to 10"),
        ({"resolution": ".inf"}, "resolution must be a number from 0.001 to 10"),
        ({"resolution": "9" * 400}, "64 bits"),
        ({"origin": "[0, 0]"}, r"origin must be \[x, y, yaw\]"),
        ({"origin": "[0, .nan, 0]"}, r"origin\[1\] must be a number"),
        ({"origin": "[0, 1.0e+300, 0]"}, r"origin\[1\] must be a number"),
        ({"origin": "0"}, r"origin must be \[x, y, yaw\]"),
        ({"image": "[]"}, "image must be text"),
        ({"image": '""'}, "image must be text"),
        ({"image": "other.png"}, "other.png does not exist"),
        ({"image": '"a\\0b"'}, "does not exist"),
        ({"image": "x" * 5000}, "cannot be read"),
        ({"image": "."}, "does not exist"),
    ],
)
def test_a_field_that_is_wrong_is_named(tmp_path: Path, fields: dict[str, str], says: str) -> None:
    with pytest.raises(Exception, match=says) as raised:
        free(tmp_path, [WHITE], **fields)
    assert type(raised.value).__name__ in ("WorldError", "YamlError")
    assert "\n" not in str(raised.value)


def png_claiming(columns: int, rows: int) -> bytes:
    """Return the beginning of a PNG with an honest check sum."""
    chunk = b"IHDR" + struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    return map_image.PNG + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "begins like neither"),
        (b"P5", "header"),
        (b"P5\n10 10\n255\n", "ends after 0 of 100 pixels"),
        (b"P5\n2 2\n1000\n" + bytes(7), "ends after 3 of 4 pixels"),
        (b"P2\n2 2\n255\n0 1 2", "ends after 3 of 4 pixels"),
        (b"P2\n2 1\n255\n0 -1", "not 0 to 255"),
        (b"P2\n2 1\n255\n0 " + b"9" * 30, "not 0 to 255"),
        (b"P2\n2 1\n255\n0 " + b"9" * 5000, "no number"),
        (b"P2\n2 1\n255\n0 x", "no number"),
        (b"P5\n2 1\n100\n" + bytes([0, 101]), "not 0 to 100"),
        (b"P5\n2 1\n0\n" + bytes(2), "largest value is 0"),
        (b"P5\n2 1\n65536\n" + bytes(4), "largest value is 65536"),
        (b"P5\n-2 1\n255\n" + bytes(4), "no pixels"),
        (b"P5\n0 1\n255\n", "no pixels"),
        (b"P5\n1000000 1000000\n255\n", "claims 1000000 x 1000000 pixels"),
        (b"P5\n20000 20000\n255\n", "claims 20000 x 20000 pixels"),
        (b"P5\n" + b"9" * 5000 + b" 1\n255\n", "claims 99999999999999999999 x 1 pixels"),
        (b"P6\n1 1\n255\n" + bytes(3), "begins like neither"),
        (map_image.PNG + b"xx", "begins like neither"),
        (png_claiming(4, 4), "data break off"),
        (png_claiming(0, 4), "no pixels"),
        (png_claiming(20_000, 20_000), "claims 20000 x 20000 pixels"),
        (png_claiming(1_000_000, 1_000_000), "claims 1000000 x 1000000 pixels"),
    ],
)
def test_an_image_that_is_damaged_or_too_large_is_one_line(tmp_path: Path, content: bytes, says: str) -> None:
    (tmp_path / "map.png").write_bytes(content)
    with pytest.raises(WorldError, match=says) as raised:
        read(tmp_path)
    assert str(tmp_path / "map.png") in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_png_that_breaks_off_or_is_changed_is_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    noise = np.random.default_rng(1).integers(0, 255, (64, 64))
    cv2.imwrite(str(tmp_path / "map.png"), noise.astype(np.uint8))
    content = (tmp_path / "map.png").read_bytes()
    damaged = [content[:length] for length in range(30, len(content), 300)]
    damaged += [content[:at] + bytes([content[at] ^ 8]) + content[at + 1 :] for at in range(25, len(content), 300)]
    for data in damaged:
        (tmp_path / "map.png").write_bytes(data)
        with pytest.raises(WorldError, match="its data"):
            read(tmp_path)
    assert capfd.readouterr().err == ""


def test_unknown_on_the_free_side_is_told_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(2):
        free(tmp_path, [WHITE, UNKNOWN], free_thresh="0.25")
    (record,) = caplog.records
    assert "free_thresh 0.25 makes grey 205 free" in record.getMessage()


@pytest.mark.parametrize(
    ("pixels", "fields"),
    [
        ([WHITE, UNKNOWN], {}),
        ([WHITE, BLACK], {"free_thresh": "0.25"}),
        ([WHITE, UNKNOWN], {"free_thresh": "0.25", "negate": "1"}),
        ([0, UNKNOWN], {"free_thresh": "0.25", "mode": "raw"}),
    ],
)
def test_nothing_is_told_where_unknown_stays_so(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, pixels: list[int], fields: dict[str, str]
) -> None:
    free(tmp_path, pixels, **fields)
    assert not caplog.records


@pytest.mark.parametrize("kind", ["pgm", "deep pgm", "plain pgm", "png", "deep png"])
def test_reading_takes_at_most_four_bytes_a_pixel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    monkeypatch.setattr(map_image, "BAND", 10_000)
    side = 1500
    pixels = np.full((side, side), WHITE, dtype=np.uint8)
    pixels[::40] = BLACK
    name = f"map.{kind[-3:]}"
    if kind == "plain pgm":
        rows = (" ".join(map(str, row)) for row in pixels.tolist())
        (tmp_path / name).write_text(f"P2\n{side} {side}\n255\n" + "\n".join(rows), encoding="ascii")
    else:
        cv2.imwrite(str(tmp_path / name), pixels.astype(np.uint16) * 257 if kind.startswith("deep") else pixels)
    tracemalloc.start()
    try:
        found = read(tmp_path, image=name)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert np.count_nonzero(~found.free) == 38 * side
    assert peak / pixels.size <= 4.0
