"""Arguments of load_robot that are odd: of xacro, paths, names, and what is kept in the cache."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import trimesh
from arms import long_arm

from humanoid_rail import InvalidInput, load_robot
from humanoid_rail.geometry.kept import cache_folder

HAND = {"hand": {"frame": "l5"}}
PAIR = '<robot name="long"><disable_collisions link1="l0" link2="l3"/></robot>'


def xacro() -> str:
    head = '<robot name="long" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="number" default="1"/>'
    more = (
        '<link name="tool_$(arg number)"/><joint name="fix" type="fixed"><parent link="l5"/>'
        '<child link="tool_$(arg number)"/></joint>'
    )
    return head + long_arm(more=more).removeprefix('<robot name="long">')


@pytest.mark.parametrize(("value", "written"), [(3, "3"), (3.5, "3.5"), (True, "true"), ("x", "x")])
def test_arguments_of_a_xacro_are_written_as_they_are_given(value: object, written: str) -> None:
    assert load_robot(xacro(), xacro={"number": value}, hands=HAND).model.existFrame(f"tool_{written}")


def test_arguments_that_a_xacro_does_not_have_are_refused() -> None:
    with pytest.raises(InvalidInput, match=r"xacro\.numbr is '3'.*did you mean number\?"):
        load_robot(xacro(), xacro={"numbr": 3}, hands=HAND)
    with pytest.raises(InvalidInput, match=r"xacro\.number.*nothing of xacro"):
        load_robot(long_arm(), xacro={"number": 3}, hands=HAND)


def test_a_package_that_xacro_does_not_find_is_said_once() -> None:
    with pytest.raises(InvalidInput, match=r"^urdf is '\$\(find nowhere\)'; valid: a package .* packages names"):
        load_robot(xacro().replace("<link name=", '<xacro:include filename="$(find nowhere)/a.xacro"/><link name=', 1))


def test_paths_that_are_arguments_begin_at_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell = tmp_path / "cell"
    (cell / "packages").mkdir(parents=True)
    (cell / "arm.urdf").write_text(long_arm())
    (cell / "robot.yaml").write_text("urdf: arm.urdf\nhands: {hand: {frame: l5}}\npackages: [packages]\n")
    (tmp_path / "my.srdf").write_text(PAIR)
    monkeypatch.chdir(tmp_path)
    for srdf in ("my.srdf", Path("my.srdf")):
        robot = load_robot("cell", srdf=srdf, packages="cell")
        assert {"l0", "l3"} in [{pair.link, pair.other} for pair in robot.left_out]
    with pytest.raises(InvalidInput, match=r"packages is .*cell/packages/packages"):
        load_robot("cell", packages="cell/packages/packages")


@pytest.mark.parametrize(
    ("source", "field", "more"),
    [
        (":x", "urdf", {}),
        ("x:", "urdf", {}),
        ("x" * 5000, "robot", {}),
        ("x" * 5000 + ".yaml", "robot", {}),
        ("x\0.urdf", "urdf", {}),
        (long_arm(), "srdf", {"srdf": "x" * 5000}),
        (long_arm(), "srdf", {"srdf": "x\0.srdf"}),
    ],
)
def test_what_cannot_be_a_name_is_not_there(source: str, field: str, more: dict[str, str]) -> None:
    with pytest.raises(InvalidInput) as error:
        load_robot(source, hands=HAND, **more)  # type: ignore[call-overload]
    assert error.value.field == field


@pytest.mark.parametrize("damage", ["{}", "[]", '{"digest": "0", "data": {}}', "junk", "changed"])
def test_what_is_damaged_in_the_cache_is_found_anew(
    damage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    robot = load_robot(long_arm(), hands=HAND)
    [file] = cache_folder("robots").glob("*.json")
    if damage == "changed":
        damage = json.dumps(json.loads(file.read_text()) | {"data": {"left_out": []}})
    file.write_text(damage)
    again = load_robot(long_arm(), hands=HAND)
    assert (again.left_out, again.initial.tolist()) == (robot.left_out, robot.initial.tolist())


def test_a_buffer_of_a_mesh_that_changes_has_all_found_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a glTF file is made of lies beside it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    body = f'<collision><geometry><mesh filename="{tmp_path}/box.gltf"/></geometry></collision>'
    found = []
    for size in (0.02, 0.03):
        mesh = trimesh.creation.box((size, size, size))
        for name, content in trimesh.exchange.gltf.export_gltf(trimesh.Scene(mesh)).items():
            (tmp_path / ("box.gltf" if name.endswith(".gltf") else name)).write_bytes(content)
        if found:  # the file itself stays as it was, as if its bounds were not in it
            (tmp_path / "box.gltf").write_bytes(found[0])
        found.append((tmp_path / "box.gltf").read_bytes())
        load_robot(long_arm(links={"l5": body}), hands=HAND)
    assert len([*cache_folder("robots").glob("*.json")]) == 2


def test_a_mesh_that_is_to_be_cut_and_is_convex_is_not_said_to_be_cut(tmp_path: Path) -> None:
    ring, ball = trimesh.creation.annulus(0.05, 0.08, 0.02), trimesh.creation.icosphere(2, 0.03)
    links = {}
    for link, mesh in (("l0", ball), ("l5", ring)):
        mesh.export(tmp_path / f"{link}.stl")
        links[link] = f'<collision><geometry><mesh filename="{tmp_path}/{link}.stl"/></geometry></collision>'
    said = load_robot(long_arm(links=links), hands=HAND, decomposed=["l0", "l5"]).report()
    assert "Cut into convex pieces: the meshes of link l5.collision[0]." in said
    assert "Left whole, as pieces would save too little: the meshes of link l0.collision[0]." in said


def test_locked_in_words_is_what_happens_anyway_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(long_arm())
    for words, is_good in (("every other joint, at 0 or at its limit", True), ("every other joint, at 0.5", False)):
        (tmp_path / "robot.yaml").write_text(f"urdf: arm.urdf\nlocked: {words}\nhands: {{hand: {{frame: l4}}}}\n")
        if is_good:
            assert dict(load_robot(tmp_path).locked) == {"j5": 0.0}
        else:
            with pytest.raises(InvalidInput, match=r"locked is .*a mapping"):
                load_robot(tmp_path)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"limits": {"acceleration": {"j1": 8}}},
            r"limits\.acceleration\.j1 is 8.*limits: \{JOINT: \{acc",
        ),
        ({"pairs": {"left_out": [["l0", "l1"]]}}, r"pairs\.left_out\[0\] is .*links: \[LINK, LINK\]"),
        ({"pairs": {"distances": [{"links": ["l0", "l3"]}]}}, r"pairs\.distances\[0\]\.distance is missing"),
        ({"pairs": {"distances": [{"links": ["l0", "l3"], "distance": -1}]}}, r"distance is -1; valid: a number, 0 or"),
        ({"hands": "l5"}, r"hands is 'l5'; valid: a mapping: hands: \{NAME: \{frame: FRAME\}\}"),
        ({"locked": "all"}, r"locked is 'all'; valid: a mapping: locked: \{JOINT: 0\.5\}"),
        ({"link_radius": 0.1}, r"link_radius is 0\.1; valid: an argument of the paper's robot alone"),
        ({"jonts": []}, r"jonts is \[\]; valid: an argument that is one of .*did you mean joints\?"),
    ],
)
def test_errors_say_what_would_be_right(given: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidInput, match=said):
        load_robot(long_arm(), **{"hands": HAND, **given})  # type: ignore[call-overload]


def test_a_hand_may_be_its_frame_alone() -> None:
    assert load_robot(long_arm(), hands={"hand": "l5"}).hands == load_robot(long_arm(), hands=HAND).hands
