"""Random malformed scenes: always a clear error, never a traceback, a hang or a half-written file."""

from __future__ import annotations

import contextlib
import copy
import json
from pathlib import Path
from typing import Any

import pytest
from conftest import plan
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_scene import VALID

from humanoid_rail import InvalidInput, Robot, load_scene

CUBE = Path(__file__).parent / "cube.obj"
# What a scene may be without.
OPTIONAL = ("name", "initial", "rpy", "scale")

# Values that no field of a scene takes.
JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.floats(allow_nan=True).filter(lambda x: not abs(x) <= 1e4),
    st.integers(min_value=10**5),
    st.text(max_size=3).map(lambda text: {text: text}),
    st.lists(st.text(max_size=3), min_size=1, max_size=4),
    st.lists(st.floats(), min_size=13, max_size=20),
    st.recursive(st.none(), lambda inner: st.lists(inner, min_size=1, max_size=3), max_leaves=20),
)


def paths(node: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the paths of all nodes of plain data."""
    inner = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    return [path, *(p for key, value in inner for p in paths(value, (*path, key)))]


@st.composite
def malformed(draw: st.DrawFn) -> str:
    """Return the text of a scene file with something wrong in it."""
    data = copy.deepcopy(VALID)
    data["obstacles"].append({"type": "mesh", "file": str(CUBE), "center": [5, 0, 1], "scale": [1, 2, 3]})
    how = draw(st.sampled_from(["replace", "rename", "add", "remove", "cut", "garble"]))
    text = json.dumps(data)
    if how == "cut":
        return text[: draw(st.integers(0, len(text) - 1))]
    if how == "garble":
        at = draw(st.sampled_from([0, draw(st.integers(0, len(text)))]))
        # Characters that YAML or UTF-8 forbids everywhere; at the start also openings that nothing closes.
        bad = ["\x01", "\x0b", "\ud800"] + ["{", "[", "'", "*x ", "@", "%", "]"] * (at == 0)
        return text[:at] + draw(st.sampled_from(bad)) + text[at:]
    path = draw(st.sampled_from([p for p in paths(data) if p]))
    node: Any = data
    for key in path[:-1]:
        node = node[key]
    if how == "replace" or (how == "remove" and path[-1] in OPTIONAL):
        # A start may be missing, and so may the target of a hand.
        node[path[-1]] = draw(JUNK.filter(lambda junk: junk is not None or path[0] not in ("initial", "targets")))
        return json.dumps(data)
    if isinstance(node, list):  # elements of lists have no names: change how many there are, or what one is
        node[path[-1]] = draw(JUNK)
    elif how == "add":
        node[draw(st.text(min_size=1).filter(lambda key: key not in node and key not in OPTIONAL))] = 1
    elif path != ("obstacles",):
        value = node.pop(path[-1])
        if how == "rename":
            node[f"{path[-1]}s"] = value
    else:
        node["obstacles"] = draw(JUNK)
    return json.dumps(data)


@settings(max_examples=500, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True, database=None)
@given(text=malformed())
def test_malformed_scenes(text: str, robot: Robot, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("scene") / "scene.yaml"
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    with pytest.raises(InvalidInput) as caught:
        plan(robot, load_scene(path), max_time=0.01, dt=0.01)
    message = str(caught.value)
    assert "; valid: " in message
    assert "\n" not in message
    assert len(message) < 1000


@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True, database=None)
@given(at=st.integers(0, 700), what=st.one_of(st.text(max_size=5), st.sampled_from(list("{}[]:,&*!|>'\"%@#-? \t\n"))))
def test_any_text_is_a_scene_or_an_error(at: int, what: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("scene") / "scene.yaml"
    text = json.dumps(VALID, indent=1)
    path.write_text(text[:at] + what + text[at:], encoding="utf-8", errors="surrogatepass")
    with contextlib.suppress(InvalidInput):
        load_scene(path)


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True, database=None)
@given(text=malformed())
def test_malformed_scenes_on_the_command_line(
    text: str, tmp_path_factory: pytest.TempPathFactory, capfd: pytest.CaptureFixture[str]
) -> None:
    from humanoid_rail.cli.console import run
    from humanoid_rail.cli.plan import command

    folder: Path = tmp_path_factory.mktemp("scene")
    (folder / "scene.yaml").write_text(text, encoding="utf-8", errors="surrogatepass")
    with pytest.raises(SystemExit) as caught:
        run(command, [str(folder / "scene.yaml"), "--out", str(folder / "out")])
    output = capfd.readouterr()
    assert caught.value.code == 2
    assert output.err.startswith("error: ")
    assert output.err.count("\n") == 1
    assert not output.out
    assert [path.name for path in folder.iterdir()] == ["scene.yaml"]
