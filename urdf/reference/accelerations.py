#!/usr/bin/env python3
"""Accelerations of robots at random states, computed by Pinocchio, as reference values for `cargo run --example compare_robots` and for the tests.

    pip install pin==4.1.0 example-robot-data==5.0.0
    python3 urdf/reference/accelerations.py FOLDER_OF_URDF_FILES OUT [--states 100]
    cargo run --release -p urdf --example compare_robots -- FOLDER_OF_URDF_FILES OUT

Gravity is -9.81 along z. Every file is read with a fixed and with a floating base. In every second state the torques are zero; otherwise they are
random. The velocities and accelerations of floating bases and planar joints are those of Pinocchio, in the axes of the moving frame.

Joints that mimic others and joints that carry no mass are eliminated from the equations of all joints, M a + b = tau: with the constant matrix G of
their dependence on the remaining velocities, G'M G a = G'(tau - b). `m` and
`r` are G'M G and G'(tau - b) of states in which the accelerations are known with few digits. `pinocchio_mimic` is the difference to the equations that Pinocchio builds itself
with `mimic=True`, where it can, and `spread` that between its two algorithms aba and crba, both relative to the largest acceleration.
"""

import argparse
import json
import pathlib
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin

# Two algorithms of Pinocchio agree less well than this.
FEW_DIGITS = 1e-12


def mimics(path):
    """{joint: (leader, factor, offset)}, composed along chains; empty if a leader does not exist."""
    joints = {joint.get("name"): joint for joint in ET.parse(path).getroot().findall("joint")}
    found = {name: joint.find("mimic") for name, joint in joints.items() if joint.get("type") != "fixed"}
    found = {name: mimic for name, mimic in found.items() if mimic is not None}
    if any(mimic.get("joint") not in joints for mimic in found.values()):
        return {}, True

    def resolve(name):
        if name not in found:
            return name, 1.0, 0.0
        mimic = found[name]
        leader, factor, offset = resolve(mimic.get("joint"))
        own = float(mimic.get("multiplier", 1))
        return leader, own * factor, own * offset + float(mimic.get("offset", 0))

    return {name: resolve(name) for name in found}, False


def reason(error):
    """The last line of a message."""
    return str(error).strip().splitlines()[-1]


def is_massless(model, joint):
    inertias = [model.inertias[k] for k in model.subtrees[joint]]
    return all(inertia.mass == 0 and not inertia.inertia.any() for inertia in inertias)


class Robot:
    def __init__(self, path, is_floating):
        root = [pin.JointModelFreeFlyer()] if is_floating else []
        self.model = pin.buildModelFromUrdf(str(path), *root)
        self.model.gravity.linear[:] = [0, 0, -9.81]
        self.data = self.model.createData()
        follows, self.ignores_mimic = mimics(path)
        model = self.model
        kinds = {(1, 1): "one", (2, 1): "one", (4, 3): "planar", (7, 6): "free"}
        self.joints, offsets, columns = [], np.zeros(model.nv), []
        for k in range(1, model.njoints):
            name, joint = model.names[k], model.joints[k]
            if name in follows:
                continue
            group = [(k, 1.0, 0.0)] + [(model.getJointId(f), *g[1:]) for f, g in follows.items() if g[0] == name]
            for follower, _, offset in group:
                offsets[model.joints[follower].idx_v] = offset
            if all(is_massless(model, follower) for follower, _, _ in group):
                continue
            self.joints.append((k, kinds[joint.nq, joint.nv]))
            for i in range(joint.nv):
                column = np.zeros(model.nv)
                for follower, factor, _ in group:
                    column[model.joints[follower].idx_v + i] = factor
                columns.append(column)
        self.offsets, self.g = offsets, np.array(columns).reshape(len(columns), model.nv).T
        self.is_whole = self.g.shape == (model.nv, model.nv)
        self.mimic = None
        if follows and not self.ignores_mimic:
            try:
                self.mimic = pin.buildModelFromUrdf(str(path), *root, mimic=True)
                self.mimic.gravity.linear[:] = [0, 0, -9.81]
            except Exception as error:
                print(f"{path.name}: Pinocchio with mimic=True: {reason(error)}", file=sys.stderr)

    def state(self, random, has_torque):
        q = []
        v = random.uniform(-1, 1, self.g.shape[1])
        tau = random.uniform(-10, 10, self.g.shape[1]) if has_torque else np.zeros(self.g.shape[1])
        first = 0
        for k, kind in self.joints:
            if kind == "free":
                e = random.normal(size=4)
                q += [*random.uniform(-1, 1, 3), *(e / np.linalg.norm(e))]
            else:
                is_slider = self.model.joints[k].shortname().startswith("JointModelP") and kind == "one"
                span = 0.3 if is_slider else np.pi
                q += list(random.uniform(-span, span, 3 if kind == "planar" else 1))
            size = {"free": 6, "planar": 3, "one": 1}[kind]
            if kind != "one":
                tau[first : first + size] = 0
            first += size
        return np.array(q), v, tau

    def configuration(self, model, q):
        """Pinocchio's configuration from the coordinates of the joints that move, those of the others following."""
        full, values, at = pin.neutral(model), self.offsets.copy(), 0
        spans, first = {}, 0
        for k, kind in self.joints:
            size = {"free": 7, "planar": 3, "one": 1}[kind]
            spans[self.model.names[k]] = q[at : at + size]
            if kind == "one":
                values += self.g[:, first] * q[at]
            at += size
            first += {"free": 6, "planar": 3, "one": 1}[kind]
        for k in range(1, model.njoints):
            joint, name = model.joints[k], model.names[k]
            if joint.shortname() == "JointModelMimic":
                continue
            own = spans.get(name)
            angle = values[self.model.joints[self.model.getJointId(name)].idx_v]
            if own is not None and len(own) == 7:
                part = own
            elif own is not None and len(own) == 3:
                part = [*own[:2], np.cos(own[2]), np.sin(own[2])]
            else:
                part = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            full[joint.idx_q : joint.idx_q + joint.nq] = part
        return full

    def accelerations(self, q, v, tau):
        model, data, full = self.model, self.data, self.configuration(self.model, q)
        m = np.array(pin.crba(model, data, full))
        m = np.triu(m) + np.triu(m, 1).T
        b = pin.nonLinearEffects(model, data, full, self.g @ v)
        m, r = self.g.T @ m @ self.g, tau - self.g.T @ b
        solved = np.linalg.solve(m, r)
        if not self.is_whole:
            return solved, 0.0, (m, r)
        a = np.array(pin.aba(model, data, full, v, tau))
        return a, np.abs(a - solved).max(initial=0) / np.abs(a).max(initial=1e-300), (m, r)

    def by_pinocchio(self, q, v, tau):
        """The same with the equations of a model that was read with mimic=True."""
        model, data = self.mimic, self.mimic.createData()
        index = np.concatenate([np.arange(model.nvs[j]) + model.idx_vs[j] for j in self.own(model)]).astype(int)
        full, velocity = self.configuration(model, q), np.zeros(model.nv)
        velocity[index] = v
        m = np.array(pin.crba(model, data, full))
        m = np.triu(m) + np.triu(m, 1).T
        b = pin.nonLinearEffects(model, data, full, velocity)
        return np.linalg.solve(m[np.ix_(index, index)], tau - b[index])

    def own(self, model):
        return [model.getJointId(self.model.names[k]) for k, _ in self.joints]


def reference(path, folder, is_floating, states):
    robot = Robot(path, is_floating)
    answer = {
        "file": str(path.relative_to(folder)),
        "floating": is_floating,
        "ignores_mimic": robot.ignores_mimic,
        "joints": [[robot.model.names[k], kind] for k, kind in robot.joints],
        "states": [],
    }
    random, spread, own = np.random.default_rng(1), 0.0, None
    for i in range(states if robot.joints else 0):
        q, v, tau = robot.state(random, i % 2 == 1)
        a, difference, (m, r) = robot.accelerations(q, v, tau)
        spread = max(spread, difference)
        equations = {"m": m.tolist(), "r": r.tolist()} if difference > FEW_DIGITS else {}
        if robot.mimic is not None:
            difference = np.abs(robot.by_pinocchio(q, v, tau) - a).max() / np.abs(a).max()
            own = max(own or 0.0, difference)
        answer["states"].append({"q": q.tolist(), "v": v.tolist(), "tau": tau.tolist(), "a": a.tolist()} | equations)
    return answer | {"spread": spread, "pinocchio_mimic": own}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--states", type=int, default=100)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for number, path in enumerate(sorted(arguments.folder.rglob("*.urdf"))):
        for is_floating in [False, True]:
            try:
                answer = reference(path, arguments.folder, is_floating, arguments.states)
            except Exception as error:
                print(f"{path.name}: {reason(error)}", file=sys.stderr)
                break
            name = f"{number:03}-{path.stem}-{'floating' if is_floating else 'fixed'}.json"
            (arguments.out / name).write_text(json.dumps(answer))


if __name__ == "__main__":
    main()
