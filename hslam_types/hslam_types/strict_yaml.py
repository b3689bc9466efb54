"""YAML as the suite reads it everywhere: plain data alone, and nothing that could be meant in two ways.

PyYAML's safe loader keeps the last of two equal keys, lets a few lines of aliases unfold into gigabytes, recurses as
deep as the text nests, and raises whatever its constructors stumble on.  Here each is one `YamlError` with its line.
Numbers are those of YAML 1.2 (``1e-3`` is one), and a date stays the text it is.
"""

import re
from typing import Any

import yaml

from hslam_types.errors import HslamError

LARGEST_TEXT = 4_000_000
"""Characters; the metadata of a bag of ten thousand files has about two million."""
DEEPEST = 64
"""Levels of nesting; no file of the suite has more than ten."""
LARGEST_INTEGER = 2**64
"""What no message and no file of the suite can hold."""

_TAG = "tag:yaml.org,2002:"
_FLOAT = re.compile(
    r"""[-+]?(?:[0-9][0-9_]*\.[0-9_]*(?:[eE][-+]?[0-9]+)?
      |\.[0-9][0-9_]*(?:[eE][-+]?[0-9]+)?
      |[0-9][0-9_]*[eE][-+]?[0-9]+
      |\.(?:inf|Inf|INF))
      |\.(?:nan|NaN|NAN)""",
    re.VERBOSE,
)


class YamlError(HslamError):
    """A text is not YAML, or not such as the suite takes; one line."""

    def __init__(self, problem: str, line: int | None = None) -> None:
        """``line`` counts from 1; None where the text as a whole is meant."""
        super().__init__(f"line {line}: {problem}" if line is not None else problem)
        self.problem = problem
        self.line = line


def load_yaml(text: str) -> Any:
    """Return the data of a YAML text: mappings, lists, text, numbers, booleans and None.

    Raises YamlError on bad syntax, a key given twice, an alias, a tag that is no plain data's, or what is too much:
    nesting, digits, length.
    """
    if len(text) > LARGEST_TEXT:
        raise YamlError(f"the text has {len(text)} characters; at most {LARGEST_TEXT} are read")
    try:
        loader = _Loader(text)
        return loader.get_single_data()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise YamlError(_one_line(error.problem or error.context), mark.line + 1 if mark else None) from None
    except yaml.YAMLError as error:
        raise YamlError(_one_line(error)) from None


class _Loader(yaml.SafeLoader):
    """PyYAML's safe loader, made strict."""

    # Without merge keys `<<` is a key like any other, which whoever reads the mapping does not know.
    yaml_implicit_resolvers = {  # noqa: RUF012 - the base class declares it so
        first: [(tag, pattern) for tag, pattern in known if tag.removeprefix(_TAG) in ("bool", "int", "null")]
        for first, known in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }
    _depth = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose one node and all below it."""
        alias = self.check_event(yaml.AliasEvent)
        here = self.current_event.start_mark
        if alias:
            raise yaml.composer.ComposerError(None, None, "aliases are not taken: write the value out", here)
        if self._depth == DEEPEST:
            raise yaml.composer.ComposerError(None, None, f"nested deeper than {DEEPEST} levels", here)
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Construct one value; PyYAML's constructors raise what their conversions raise."""
        try:
            value = super().construct_object(node, deep=deep)
        except (ValueError, KeyError, IndexError, AttributeError, TypeError):
            kind = node.tag.removeprefix(_TAG)
            raise yaml.constructor.ConstructorError(None, None, f"the value is no {kind}", node.start_mark) from None
        if isinstance(value, int) and abs(value) >= LARGEST_INTEGER:
            raise yaml.constructor.ConstructorError(None, None, "an integer has more than 64 bits", node.start_mark)
        return value

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Construct a mapping whose keys all differ."""
        mapping = super().construct_mapping(node, deep=deep)
        if len(mapping) < len(node.value):
            keys = [self.construct_object(key, deep=True) for key, _ in node.value]
            again = next(number for number, key in enumerate(keys) if key in keys[:number])
            raise yaml.constructor.ConstructorError(
                None, None, f"the key '{keys[again]}' is given twice", node.value[again][0].start_mark
            )
        return mapping


_Loader.add_implicit_resolver(f"{_TAG}float", _FLOAT, list("-+0123456789."))


def _one_line(problem: object) -> str:
    return " ".join(str(problem).split())
