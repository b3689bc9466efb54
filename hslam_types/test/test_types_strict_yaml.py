"""Strict YAML: what it reads is what PyYAML reads, and what could be meant in two ways or too much is refused."""

import contextlib
import datetime as dt
import math

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from hslam_types.strict_yaml import DEEPEST, YamlError, load_yaml

BOMB = "a0: &a0 [x, x]\n" + "".join(f"a{n}: &a{n} [*a{n - 1}, *a{n - 1}]\n" for n in range(1, 40))
MERGES = "a0: &a0 {x: 1}\n" + "".join(f"a{n}: &a{n} {{<<: [*a{n - 1}, *a{n - 1}]}}\n" for n in range(1, 40))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3),
        ("-1E5", -1e5),
        ("1.5e+2", 150.0),
        (".5", 0.5),
        ("3", 3),
        ("0x10", 16),
        ("-.inf", -math.inf),
        ("yes", True),
        ("~", None),
        ("", None),
        ("2026-11-25", "2026-11-25"),
        ("e5", "e5"),
        ("1e", "1e"),
        ("{<<: 1}", {"<<": 1}),
        ("{=: 1}", {"=": 1}),
        ("[1, {a: b}]", [1, {"a": "b"}]),
        (str(2**64 - 1), 2**64 - 1),
    ],
)
def test_plain_data_is_read(text: str, value: object) -> None:
    read = load_yaml(text)
    assert read == value
    assert type(read) is type(value)


def test_not_a_number_is_read_as_such() -> None:
    assert math.isnan(load_yaml(".nan"))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: 1\nb: 2\na: 3", r"line 3: the key 'a' is given twice"),
        ("x: {a: 1, b: {c: 1, c: 1}}", r"line 1: the key 'c' is given twice"),
        ("1: a\n1.0: b", r"line 2: the key '1.0' is given twice"),
        ("a: &a [1]\nb: *a", r"line 2: aliases are not taken"),
        ("a: &a 1\nb:\n  - *a\n\n\nc: 2", r"line 3: aliases are not taken"),
        ("&a [*a]", "aliases are not taken"),
        (BOMB, "aliases are not taken"),
        (MERGES, "aliases are not taken"),
        ("a: [1,\nb: }", r"line \d+: "),
        ("[" * 5000 + "]" * 5000, "nested deeper"),
        ("- " * 5000 + "x", "nested deeper"),
        ("9" * 400, "more than 64 bits"),
        ("-" + "9" * 400, "more than 64 bits"),
        ("a: " + "9" * 5000, "line 1: the value is no int"),
        ("!!int x", "the value is no int"),
        ("!!int ''", "the value is no int"),
        ("!!bool x", "the value is no bool"),
        ("!!float x", "the value is no float"),
        ("!!timestamp x", "the value is no timestamp"),
        ("!!python/object/apply:os.getcwd []", "could not determine a constructor"),
        ("{[a]: 1}", "unhashable key"),
        ("{? {a: 1} : 1}", "unhashable key"),
        ("a\0b", "special characters"),
        ("--- 1\n--- 2", "but found another document"),
        ("x" * 4_000_001, "at most 4000000"),
    ],
)
def test_what_could_be_meant_in_two_ways_or_is_too_much_is_one_line(text: str, says: str) -> None:
    with pytest.raises(YamlError, match=says) as raised:
        load_yaml(text)
    assert "\n" not in str(raised.value)


def test_the_deepest_nesting_taken_is_read() -> None:
    value = load_yaml("[" * DEEPEST + "]" * DEEPEST)
    for _ in range(DEEPEST - 1):
        (value,) = value
    assert value == []
    with pytest.raises(YamlError):
        load_yaml("[" * (DEEPEST + 1) + "]" * (DEEPEST + 1))


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**63) | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


@given(value=PLAIN)
def test_what_pyyaml_writes_is_read_back(value: object) -> None:
    class Unshared(yaml.SafeDumper):
        def ignore_aliases(self, _: object) -> bool:
            return True

    assert load_yaml(yaml.dump(value, Dumper=Unshared)) == value


@given(text=st.text(alphabet="ab01.-+e:_ ,[]{}&*!?|>'\"#%@\n\t<=~", max_size=40))
def test_no_text_raises_anything_else(text: str) -> None:
    value: object = None
    with contextlib.suppress(YamlError):
        value = load_yaml(text)
    assert not isinstance(value, dt.date)
