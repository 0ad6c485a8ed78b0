"""The table of all tools: `table.py PROGRAM ROUNDS`, where PROGRAM is the compiled example `robot` of the crate `urdf`.

Every round runs every tool once in a process of its own; times are medians over the rounds.
"""

import json
import pathlib
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile

import task
from common import version

HERE = pathlib.Path(__file__).resolve().parent
NAMES = {"crocoddyl": "Crocoddyl", "pinocchio": "Pinocchio, loop in Python", "mujoco": "MuJoCo"}


def run(command):
    """Standard output of a program as JSON; fails with the last line that it wrote."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError((done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1])
    return json.loads(done.stdout)


class Crate:
    """The crate, as a fresh copy of its program: the location of its pages in memory changes times and is the same in all runs of one file."""

    def __init__(self, program, folder):
        self.program, self.copy = pathlib.Path(program), folder / "robot"

    def command(self, name, path, damping, finer=1):
        joints = task.joints(name)
        order = [joint for joint in self.order(path)]
        numbers = lambda values: ",".join(map(str, values))
        start = numbers(joints[joint][0] for joint in order)
        return [self.copy, "--urdf", path, "--steps", task.STEPS * finer, "--dt", task.DT / finer, "--start", start, "--target", start,
                "--torque", numbers(joints[joint][1] for joint in order), "--damping", numbers([damping] * len(order))]

    def order(self, path):
        """The joints in the order of the program's arguments."""
        return run([self.copy, "--urdf", path, "--steps", 1, "--dt", 1e-6])["joints"]

    def renew(self):
        self.copy.unlink(missing_ok=True)
        shutil.copy(self.program, self.copy)

    def results(self, name, path):
        self.renew()
        for damping in (task.DAMPING, 0.0):
            found = run(self.command(name, path, damping) + ["--repeat", 20])
            times = [1e6 * found[key] / task.STEPS for key in ("forward_s", "value_and_gradient_s")]
            gradient = dict(zip(found["joints"], found["gradient"]))
            yield task.result("trapezoidal rule", found["cost"], gradient, times, [None, None], None, damping) | {"program": found["instructions"]}

    def reference(self, name, path, damping):
        """J and its gradient with small steps and a method of order 5."""
        found = run(self.command(name, path, damping, task.FINER) + ["--scheme", "ESDIRK5"])
        return found["cost"], dict(zip(found["joints"], found["gradient"]))


def measure(crate, path, name, rounds):
    """{tool: results of each round, or the error of the first that failed}."""
    found = {"crate": [], **{tool: [] for tool in NAMES}}
    for _ in range(rounds):
        found["crate"].append(list(crate.results(name, path)))
        for tool in NAMES:
            if isinstance(found[tool], list):
                try:
                    found[tool].append(run([sys.executable, HERE / f"{tool}_robot.py", name, path]))
                except RuntimeError as error:
                    found[tool] = str(error).replace("|", "/")
    return found


def row(tool, rounds, references):
    """One line from the results of one scheme in all rounds."""
    last = rounds[-1]
    median = lambda key, i: statistics.median(each[key][i] for each in rounds) if last[key][i] is not None else None
    number = lambda x: "" if x is None else f"{x:.3g}"
    expected, by_torque = references[last["damping"]]
    size = max(map(abs, by_torque.values()))
    worst = max(abs(last["gradient"][joint] - slope) for joint, slope in by_torque.items())
    finer = "" if last["finer"] is None else f"{abs(last['finer'] / expected - 1):.0e}"
    cells = [tool, last["scheme"], "yes" if last["damping"] else "no", *(number(median(key, i)) for key in ("times", "library") for i in (0, 1)),
             f"{abs(last['value'] / expected - 1):.0e}", f"{worst / size:.0e}", finer]
    print("| " + " | ".join(cells) + " |", flush=True)


def table(crate, folder, name, rounds):
    path = folder / f"{name}.urdf"
    task.write_urdf(name, path)
    found = measure(crate, path, name, rounds)
    references = {damping: crate.reference(name, path, damping) for damping in (task.DAMPING, 0.0)}
    print(f"\n{name}, {len(task.joints(name))} joints:\n")
    print("| tool | scheme | damping | simulation, µs | value and gradient, µs | library alone: simulation | derivatives | error of J "
          "| error of dJ/dτ | J with small steps differs by |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for tool, results in found.items():
        if isinstance(results, str):
            print(f"| {NAMES[tool]} | | | | | | | | | failed: {results} |")
            continue
        for rounds_of_scheme in zip(*results):
            row(NAMES.get(tool, "this crate"), rounds_of_scheme, references)
    programs = found["crate"][-1][0]["program"]
    print(f"\nLengths of the programs of the crate: " + ", ".join(f"{what} {length}" for what, length in sorted(programs.items())) + ".")
    print("<!-- arguments:", *crate.command(name, path, task.DAMPING)[1:], "-->" if False else "-->")


def main():
    program, rounds = sys.argv[1], int(sys.argv[2])
    packages = ("numpy", "pin", "crocoddyl", "mujoco", "example-robot-data")
    print(f"Python {platform.python_version()}: " + ", ".join(f"{package} {version(package)}" for package in packages) + f"; medians of {rounds} rounds")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        crate = Crate(program, folder)
        crate.renew()
        for name in task.ROBOTS:
            table(crate, folder, name, rounds)


main()
