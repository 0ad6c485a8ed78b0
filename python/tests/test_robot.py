"""Robots from URDF files."""

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from test_paper import assert_same

LINK = """<link name="{name}"><inertial><origin xyz="0 0 -0.5"/><mass value="{mass}"/>
  <inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="{type}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 {z}"/><axis xyz="0 1 0"/>
  <limit lower="-2" upper="2" effort="10" velocity="3"/>{more}</joint>"""
ARM = "\n".join(
    [
        '<robot name="arm"><link name="base link"/>',
        LINK.format(name="upper arm", mass=2),
        LINK.format(name="forearm", mass=1),
        JOINT.format(name="shoulder", type="revolute", parent="base link", child="upper arm", z=0, more='<dynamics damping="0.3" friction="0.1"/>'),
        JOINT.format(name="elbow", type="revolute", parent="upper arm", child="forearm", z=-1, more=""),
        "</robot>",
    ]
)


HEAVY = ARM.replace('<link name="base link"/>', LINK.format(name="base link", mass=5))


def arm(**options):
    scene = ha.Scene()
    scene.gravity(0.0, 0.0, -9.81)
    return scene, scene.robot(ARM, **options)


def test_an_arm():
    scene, robot = arm()
    assert list(robot) == ["shoulder", "elbow"] and len(robot) == 2 and list(robot.links) == ["base link", "upper arm", "forearm"]
    shoulder, elbow = robot["shoulder"].angle, robot["elbow"].angle
    assert [x.name for x in robot.coordinates] == ["shoulder.angle", "elbow.angle"] == [shoulder.name, elbow.name]
    assert robot.data["shoulder"] == (-2.0, 2.0, 3.0, 10.0, 0.3, 0.1)
    assert scene["shoulder"].angle.name == "shoulder.angle" and isinstance(scene["upper arm"], ha.SpaceBody)
    torques = robot.drive()
    assert [of.name for of in torques] == ["shoulder", "elbow"] and isinstance(scene["shoulder"], ha.Control)
    assert scene.find("shoulder", "joint").angle.name == "shoulder.angle"
    scene.place(shoulder, 0.4)
    scene.cost("angles", 0.5 * ((shoulder - 1.0) ** 2 + elbow**2), sum="terminal")
    system = scene.compile()
    assert (system.n, system.m) == (2, 0)
    inputs = system.at_rest(50, 0.01)
    inputs.controls[:] = [[3.0], [1.0]]
    ha.check_gradient(system, inputs).assert_passed()
    # Statics: the torques that hold the arm.
    hold = system.at_rest(100, 0.01)
    angle = 0.4
    hold[torques[0]] = (2 * 0.5 + 1 * 1.5) * 9.81 * np.sin(angle)
    hold[torques[1]] = 1 * 0.5 * 9.81 * np.sin(angle)
    assert ha.simulate(system, hold).q == pytest.approx(np.array([[angle], [0.0]]).repeat(101, axis=1), abs=1e-9)


def test_the_scene_as_a_file(tmp_path):
    (tmp_path / "arm.urdf").write_text(HEAVY, encoding="utf-8")
    scene = ha.Scene()
    robot = scene.robot(tmp_path / "arm.urdf", floating=True, damping=True, prefix="left ")
    assert robot.base.x.name == "left base.x"
    scene.robot(str(tmp_path / "arm.urdf"), prefix="right ", locked={"elbow": 0.5})
    left, right = robot.coordinates, scene["right shoulder"].angle
    scene.place(left[0], 0.4)
    scene.cost("angles", left[0] ** 2 + left[1] ** 2 + right**2, sum="integral")
    scene.gravity(0.0, 1.0, -9.81)
    scene.save(tmp_path / "scene.json")

    def gradient(of):
        system = of.compile()
        return ha.gradient(system, system.at_rest(20, 0.01))

    expected = gradient(scene)
    assert expected.value > 0
    assert_same(gradient(ha.Scene.load(tmp_path / "scene.json")), expected)


def test_options():
    scene, robot = arm(locked={"elbow": 0.2}, prefix="my ")
    assert robot.locked == {"elbow": 0.2} and list(robot) == ["shoulder"] and robot["shoulder"].angle.name == "my shoulder.angle"
    scene = ha.Scene()
    robot = scene.robot(HEAVY, floating=True)
    assert robot.base.x.name == "base.x" and scene.compile().n == 9
    mimic = ARM.replace("</robot>", "").replace('child link="forearm"/>', 'child link="forearm"/><mimic joint="shoulder" multiplier="-2"/>') + "</robot>"
    scene = ha.Scene()
    assert scene.robot(mimic).followers == {"elbow": ("shoulder", -2.0, 0.0)} and scene.compile().n == 1
    scene = ha.Scene()
    assert list(scene.robot(mimic, ignore_mimic=True)) == ["shoulder", "elbow"]


def test_damping_of_the_file():
    def turned(**options):
        scene, robot = arm(**options, locked={"elbow": 0.0})
        scene.gravity(0.0, 0.0, 0.0)
        system = scene.compile()
        inputs = system.at_rest(1000, 0.001)
        inputs[robot["shoulder"].angle.v] = 1.0
        return ha.simulate(system, inputs)[robot["shoulder"].angle.v][-1]

    # J = Σ (J_c + m r²) about the shoulder; v = exp(−d t/J).
    inertia = 0.02 + 2 * 0.5**2 + 0.02 + 1 * 1.5**2
    assert turned() == pytest.approx(1.0) and turned(damping=True) == pytest.approx(np.exp(-0.3 / inertia), rel=1e-7)


def test_impossible_inertias():
    scene = ha.Scene()
    robot = scene.robot(ARM.replace('ixx="0.02"', 'ixx="9"'), accept_impossible_inertias=True)
    assert len(robot) == 2 and scene.compile().n == 2


@pytest.mark.parametrize(
    "text, message",
    [
        (ARM.replace("</robot>", ""), "not well-formed"),
        (ARM.replace('<mass value="1"/>', ""), "line 4, column .*`mass`"),
        (ARM.replace('ixx="0.02"', 'ixx="9"'), "larger than the sum of the other two; correct them or pass `accept_impossible_inertias=True`"),
        (ARM.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><mimic joint="wrist"/>'), "does not exist; correct it or pass `ignore_mimic=True`"),
    ],
)
def test_mistakes(text, message):
    scene = ha.Scene()
    with pytest.raises(ha.FileError, match=message):
        scene.robot(text)
    assert "0 parts" in repr(scene)


def test_names_that_are_taken():
    scene, robot = arm()
    with pytest.raises(ha.SceneError, match="`base link` already; .* by prefix='left '"):
        scene.robot(ARM)
    assert len(scene.robot(ARM, prefix="left ").drive()) == len(robot.drive()) == 2
    with pytest.raises(ha.SceneError, match="a control `shoulder` already; `drive` is called once"):
        robot.drive()
    scene.compile()
    with pytest.raises(KeyError, match="no link `forarm`; did you mean `forearm`?"):
        robot.links["forarm"]
    with pytest.raises(KeyError, match="no moving joint `wrist`; its joints are shoulder, elbow"):
        robot["wrist"]
    with pytest.raises(FileNotFoundError):
        scene.robot("no such file.urdf")
