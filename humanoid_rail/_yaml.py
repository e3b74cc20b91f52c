"""YAML, and JSON as a part of it."""

from __future__ import annotations

from humanoid_rail.errors import InvalidInput


def parse_yaml(field: str, text: str, source: str) -> object:
    """Return the data in YAML 1.2, of which JSON is a part.

    Args:
        field: What errors call the file.
        text: What is in it.
        source: Its name, for errors.

    Raises:
        InvalidInput: If it is no YAML.
    """
    # Imported here: data need not come from a file.
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    # The pure loader is the one that reads YAML 1.2, in which 1e-3 is a number and JSON is YAML.
    try:
        return YAML(typ="safe", pure=True).load(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = text.splitlines()[mark.line] if mark and mark.line < len(text.splitlines()) else text
        where = f"{source}:{mark.line + 1}:{mark.column + 1}" if mark else source
        raise InvalidInput(field, line, f"YAML: {error.problem or error.context}", where) from None
    except RecursionError:
        raise InvalidInput(field, text, "YAML that is not nested so deeply", source) from None
    except (YAMLError, ValueError, TypeError, AttributeError, LookupError, AssertionError) as error:
        raise InvalidInput(field, text, f"YAML: {error}", source) from None
