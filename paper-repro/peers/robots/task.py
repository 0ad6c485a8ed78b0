"""Two robots under constant torques: the same URDF file, pose, torques, damping, steps and cost for all tools.

J = 1/2 |q - target|^2 + 0.005 |v|^2 at the end, over the joints with one coordinate; target = pose at the start. A program for one tool is called
with the name of a robot and prints a list of results, one for each scheme: those of `result`.
"""

import json
import pathlib
import statistics
import sys
import time
import xml.etree.ElementTree as ET

import numpy as np

STEPS = 100
DT = 0.002
DAMPING = 0.5
FINER = 32  # the factor by which steps are smaller in checks of convergence

LEG = {"hip_pitch": (-0.3, 3.0), "hip_roll": (0.1, 3.0), "hip_yaw": (0.0, 0.3), "knee": (0.6, -2.0), "ankle_pitch": (-0.3, 0.03),
       "ankle_roll": (0.0, 0.005)}
ARM = {"shoulder_pitch": (0.2, 1.5), "shoulder_roll": (0.2, 1.0), "shoulder_yaw": (0.0, 0.4), "elbow": (0.5, -0.3),
       "wrist_roll": (0.0, 0.005), "wrist_pitch": (0.2, 0.02), "wrist_yaw": (0.0, 0.01)}


def both_sides(joints):
    """Joints of both sides of a body; those of the right side are pushed in the opposite direction."""
    sides = (("left", 1.0), ("right", -1.0))
    return {f"{side}_{name}_joint": (angle, sign * torque) for side, sign in sides for name, (angle, torque) in joints.items()}


# URDF file, joints that are locked, link that moves freely, {joint: (angle at the start, torque)}.
ROBOTS = {
    "panda": (
        "panda_description/urdf/panda.urdf",
        ("panda_finger_joint1", "panda_finger_joint2"),
        None,
        dict(zip((f"panda_joint{i}" for i in range(1, 8)),
                 zip((0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8), (10.0, -14.0, 6.0, 30.0, 1.5, 1.5, 0.1)))),
    ),
    "g1": (
        "g1_description/urdf/g1_29dof_rev_1_0.urdf",
        (),
        "pelvis",
        both_sides(LEG) | {"waist_yaw_joint": (0.0, 1.0), "waist_roll_joint": (0.0, 2.0), "waist_pitch_joint": (0.1, 1.0)} | both_sides(ARM),
    ),
}


def models():
    """The folder of example-robot-data, which is installed beside Pinocchio."""
    found = [folder for path in map(pathlib.Path, sys.path) for folder in path.glob("cmeel.prefix/share/example-robot-data/robots")]
    if not found:
        raise FileNotFoundError("example-robot-data is not installed")
    return found[0]


def write_urdf(name, path):
    """Writes the file that all tools read: without shapes, locked joints fixed, free links below a joint of the type floating."""
    source, locked, free, _ = ROBOTS[name]
    tree = ET.parse(models() / source)
    root = tree.getroot()
    for link in root.findall("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            link.remove(shape)
    for joint in root.findall("joint"):
        if joint.get("name") in locked:
            joint.set("type", "fixed")
    if free:
        ET.SubElement(root, "link", name="world")
        # Crocoddyl finds a free base by the name `root_joint`.
        joint = ET.SubElement(root, "joint", name="root_joint", type="floating")
        ET.SubElement(joint, "parent", link="world")
        ET.SubElement(joint, "child", link=free)
    tree.write(path)


def joints(name):
    return ROBOTS[name][3]


def cost(q, v, start):
    """J and its derivatives with respect to q and v, of the joints."""
    return 0.5 * (q - start) @ (q - start) + 0.005 * v @ v, q - start, 0.01 * v


def time_us(function, budget=0.2):
    """The median time of a step after one call that is not timed; a call computes all steps."""
    function()
    times, end = [], time.perf_counter() + budget
    while len(times) < 3 or time.perf_counter() < end:
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return 1e6 * statistics.median(times) / STEPS


def result(scheme, value, gradient, times, library=(None, None), finer=None, damping=DAMPING):
    """`gradient`: {joint: dJ/dtorque}; `times` of a step: simulation, value and gradient; `library`: simulation and derivatives of all steps by
    functions of the library alone, without Python; `finer`: J by an accurate scheme with small steps."""
    return {"scheme": scheme, "value": value, "gradient": gradient, "times": times, "library": library, "finer": finer, "damping": damping}


def main(results):
    """Runs one tool: arguments are the robot and its URDF file."""
    name, path = sys.argv[1:]
    print(json.dumps(list(results(joints(name), path))))
