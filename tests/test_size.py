"""Files and functions stay small enough to be read at once."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT

LONGEST_FILE, LONGEST_FUNCTION = 300, 60
"""The most lines of each, docstrings and comments included."""
FOLDERS = ("humanoid_rail", "benchmarks", "validation", "scripts")
PYTHON = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))
CPP = sorted(path for path in (ROOT / "engine").rglob("*") if path.suffix in (".cpp", ".hpp"))
CONTAINER = re.compile(r"\b(namespace|class|struct|enum|union|extern)\b[^;(){}]*$")
"""What stands before the brace of a block in which functions are declared."""
NO_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|R"\((.*?)\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.DOTALL)


def test_there_are_files() -> None:
    assert len(PYTHON) > 50
    assert len(CPP) > 20


def test_files_are_short() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in (*PYTHON, *CPP)}
    assert {str(path.relative_to(ROOT)): n for path, n in lengths.items() if n > LONGEST_FILE} == {}


def python_functions(text: str) -> Iterator[tuple[str, int]]:
    """Yield the functions of a module with their numbers of lines."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert node.end_lineno is not None
            yield node.name, node.end_lineno - node.lineno + 1


def cpp_functions(text: str) -> Iterator[tuple[str, int]]:
    """Yield the blocks of braces outside of functions, with their numbers of lines: the bodies of functions, mostly."""
    code = NO_CODE.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
    inside, begun, since = list[bool](), 0, 0
    for at, character in enumerate(code):
        if character == "{":
            head = code[since:at]
            if all(inside):
                begun = at
            inside.append(all(inside) and CONTAINER.search(head.strip()) is not None)
            since = at + 1
        elif character == "}":
            was_container = inside.pop()
            since = at + 1
            if not was_container and all(inside):
                first = code.rfind("\n", 0, begun) + 1
                yield code[first:begun].strip(), code.count("\n", begun, at) + 1
        elif character == ";":
            since = at + 1
    assert not inside, "unbalanced braces"


@pytest.mark.parametrize("path", PYTHON, ids=lambda path: str(path.relative_to(ROOT)))
def test_python_functions_are_short(path: Path) -> None:
    found = python_functions(path.read_text(encoding="utf-8"))
    assert [(name, n) for name, n in found if n > LONGEST_FUNCTION] == []


@pytest.mark.parametrize("path", CPP, ids=lambda path: str(path.relative_to(ROOT)))
def test_cpp_functions_are_short(path: Path) -> None:
    found = cpp_functions(path.read_text(encoding="utf-8"))
    assert [(name, n) for name, n in found if n > LONGEST_FUNCTION] == []


def test_functions_of_cpp_are_found() -> None:
    text = """
namespace a {
namespace {
enum class E { one, two };
// no { brace
const char* brace() { return "{"; }
}  // namespace
class C : public B<int> {
 public:
  C(int a) : a_{a}, b_{a} {
    if (a) {
      f([&] { return '}'; });
    }
  }
  std::vector<int> b_{1};
};
template <class T>
void g(T t) {

}
}
"""
    found = [(name, n) for name, n in cpp_functions(text) if not name.endswith(("_", "a_{a}, b_"))]
    assert found == [
        ("const char* brace()", 1),
        ("C(int a) : a_{a}, b_{a}", 5),
        ("void g(T t)", 3),
    ]
