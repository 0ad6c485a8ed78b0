"""The table of all tools: `table.py PROGRAM ROUNDS`, where PROGRAM is the compiled example `robot` of the crate `urdf`.

Every round runs every tool in a process of its own; times are medians over the rounds. Fails if the converged costs of two tools differ.
"""

import json
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

import task
from common import versions

HERE = pathlib.Path(__file__).resolve().parent
CRATE = "this crate"
TOOLS = {"crocoddyl_robot.py": "Crocoddyl", "pinocchio_robot.py": "Pinocchio, loop in Python", "mujoco_robot.py": "MuJoCo"}
LARGER = 5  # the factor by which steps are larger in a second row of the crate
AGREEMENT = 1e-10  # relative difference of converged costs


class Failure(Exception):
    pass


def run(command):
    """Standard output of a program and what it wrote to standard error."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        raise Failure((done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1].replace("|", "/"))
    return done.stdout, done.stderr


class Crate:
    """One robot in the crate."""

    def __init__(self, program, folder, name, path):
        self.program, self.copy, self.path = program, folder / "robot", path
        answer = run([program, "--urdf", path, "--steps", 1, "--dt", task.DT])[0]
        self.names = json.loads(answer)["joints"]
        self.start, self.torque = zip(*(task.joints(name)[joint] for joint in self.names))

    def command(self, damping, larger=1.0):
        numbers = lambda values: ",".join(map(str, values))
        return [self.copy, "--urdf", self.path, "--steps", round(task.STEPS / larger), "--dt", task.DT * larger, "--start", numbers(self.start),
                "--target", numbers(self.start), "--torque", numbers(self.torque), "--damping", numbers([damping] * len(self.names))]

    def solve(self, *arguments):
        found = json.loads(run(arguments)[0])
        return found, found["cost"], dict(zip(self.names, found["gradient"]))

    def results(self):
        """Runs a fresh copy of the program: the location of its pages in memory changes times and is the same in all runs of one file."""
        self.copy.unlink(missing_ok=True)
        shutil.copy(self.program, self.copy)
        for damping, larger in ((task.DAMPING, 1), (task.DAMPING, LARGER), (0.0, 1)):
            found, cost, gradient = self.solve(*self.command(damping, larger), "--repeat", 20)
            times = [1e6 * found[key] / task.STEPS for key in ("forward_s", "value_and_gradient_s")]
            yield task.result(f"trapezoidal rule, {1e3 * task.DT * larger:.0f} ms", cost, gradient, times, damping=damping)

    def reference(self, damping):
        """J and its gradient with small steps and a method of order 5."""
        return self.solve(*self.command(damping, 1 / task.FINER), "--scheme", "ESDIRK5")[1:]

    def programs(self):
        found = self.solve(*self.command(0.0))[0]["instructions"]
        return ", ".join(f"{length} ({what})" for what, length in sorted(found.items()))

    def instructions(self):
        """Machine instructions of a step for value and gradient, from the difference of four repetitions."""
        if not shutil.which("valgrind"):
            return "not counted, because valgrind is not installed"
        valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
        count = lambda repeat: int(re.search(r"Collected : (\d+)", run([*valgrind, *self.command(task.DAMPING), "--repeat", repeat])[1])[1])
        return (count(6) - count(2)) // (4 * task.STEPS)


def measure(crate, name, rounds):
    """{tool: results of all rounds}, and {tool: error} of those that failed."""
    found, failed = {CRATE: [], **{tool: [] for tool in TOOLS.values()}}, {}
    for _ in range(rounds):
        found[CRATE].append(list(crate.results()))
        for file, tool in TOOLS.items():
            if tool not in failed:
                try:
                    found[tool].append(json.loads(run([sys.executable, HERE / file, name, crate.path])[0]))
                except Failure as failure:
                    failed[tool] = failure
    return found, failed


def row(tool, rounds, references):
    """One line from the results of one scheme in all rounds."""
    last = rounds[-1]
    cost, gradient = references[last["damping"]]
    times = [[each[key][i] for each in rounds] for key in ("times", "library") for i in (0, 1)]
    times = ["" if None in each else f"{statistics.median(each):.3g}" for each in times]
    finer = ""
    if last["finer"] is not None:
        difference = abs(last["finer"] / cost - 1)
        finer = f"{difference:.0e}"
        if difference > AGREEMENT:
            raise Failure(f"{tool}: the converged cost is {last['finer']} instead of {cost}; the models differ")
    error = f"{abs(last['value'] / cost - 1):.0e}"
    return [tool, last["scheme"], "yes" if last["damping"] else "no", *times, error, f"{distance(last['gradient'], gradient):.0e}", finer]


def distance(gradient, expected):
    """The largest difference, relative to the largest entry."""
    return max(abs(gradient[joint] - expected[joint]) for joint in expected) / max(map(abs, expected.values()))


def table(crate, name, rounds):
    found, failed = measure(crate, name, rounds)
    references = {damping: crate.reference(damping) for damping in (task.DAMPING, 0.0)}
    print(f"\n{name}, {len(crate.names)} joints; a step of the crate for value and gradient: {crate.instructions()} instructions; lengths of its",
          f"programs: {crate.programs()}\n")
    print("| tool | scheme | damping | simulation, µs | value and gradient, µs | library alone: simulation | derivatives | error of J "
          "| error of dJ/dτ | converged J differs by |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for tool in found:
        rows = [[tool] + [""] * 8 + [f"failed: {failed[tool]}"]] if tool in failed else [row(tool, each, references) for each in zip(*found[tool])]
        for cells in rows:
            print("| " + " | ".join(cells) + " |", flush=True)
    same_scheme(*(found[tool][-1] for tool in ("Pinocchio, loop in Python", "MuJoCo") if tool not in failed))


def same_scheme(exact=(), quotients=()):
    """MuJoCo and the loop around Pinocchio solve the same equations, so their gradients differ by the error of difference quotients."""
    if exact and quotients:
        cost = abs(quotients[0]["value"] / exact[0]["value"] - 1)
        gradients = " and ".join(f"{distance(each['gradient'], exact[0]['gradient']):.0e}" for each in quotients)
        print(f"\nMuJoCo and Pinocchio with the same scheme: J differs by {cost:.0e}, dJ/dτ by {gradients} (one-sided and central differences).")


def main():
    program, rounds = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    print(versions(["numpy", "pin", "crocoddyl", "mujoco", "example-robot-data"]) + f"; medians of {rounds} rounds; times of 2 ms of motion")
    with tempfile.TemporaryDirectory() as folder:
        for name in task.ROBOTS:
            path = pathlib.Path(folder) / f"{name}.urdf"
            task.write_urdf(name, path)
            table(Crate(program, pathlib.Path(folder), name, path), name, rounds)


try:
    main()
except Failure as failure:
    sys.exit(f"error: {failure}")
