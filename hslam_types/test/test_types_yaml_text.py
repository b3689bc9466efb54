"""YAML of any shape is a plain value or one line."""

import contextlib
import math

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.yaml_text import YamlError, load_yaml

BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join([f'*{before}'] * 10)}]\n" for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
MERGES = "a: &a {k: v}\n" + "".join(
    f"{name}: &{name} {{<<: [{', '.join([f'*{before}'] * 10)}]}}\n"
    for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3),
        ("-2E6", -2e6),
        ("1.5e3", 1500.0),
        (".5e1", 5.0),
        ("7", 7),
        ("1.25", 1.25),
        (".inf", math.inf),
        ("true", True),
        ("~", None),
        ("2026-11-25", "2026-11-25"),
        ("2026-13-45", "2026-13-45"),
        ("12e", "12e"),
        ("e5", "e5"),
        ("18446744073709551615", 2**64 - 1),
        ("[&a [1], *a]", [[1], [1]]),
        ("base: &b {x: 1}\nown: {<<: *b, x: 2}", {"base": {"x": 1}, "own": {"x": 2}}),
    ],
)
def test_a_plain_value_is_itself(text: str, value: object) -> None:
    found = load_yaml(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a: [", "line 1: "),
        ("ok: 1\nb: }", "line 2: "),
        ("x: 1\ny: 2\nx: 3", "line 3: the key 'x' is there twice"),
        ("1" * 5000, "a value is not what its tag says"),
        ("1" * 400, "line 1: a whole number of more than 64 bits"),
        ("-18446744073709551616", "line 1: a whole number of more than 64 bits"),
        ("[" * 5000, "is nested too deeply"),
        ("{a: " * 5000, "is nested too deeply"),
        ("&a [*a]", "line 1: an alias stands within what it stands for"),
        (BOMB, ": aliases make more of this than can be meant"),
        (MERGES, ": aliases make more of this than can be meant"),
        ("!!timestamp x", "a value is not what its tag says"),
        ("!!bool maybe", "a value is not what its tag says"),
        ("!!int ''", "a value is not what its tag says"),
        ("!!python/object/apply:os.getcwd []", "line 1: could not determine a constructor"),
        ("*nobody", "line 1: found undefined alias"),
        ("{[1]: 2}", "line 1: found unhashable key"),
        ("\0", "special characters are not allowed"),
        ("a: 1\n---\nb: 2", "line 2: "),
    ],
)
def test_anything_else_is_one_line(text: str, told: str) -> None:
    with pytest.raises(YamlError) as caught:
        load_yaml(text)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**63) | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@given(PLAIN)
def test_what_a_library_wrote_is_read_as_it_was(value: object) -> None:
    assert load_yaml(yaml.safe_dump(value)) == value


@given(st.text(alphabet="abc019 \n-:[]{},&*!|>'\"#.e+%~@?<=\t", max_size=60))
def test_no_text_ends_in_another_error(text: str) -> None:
    with contextlib.suppress(YamlError):
        load_yaml(text)
