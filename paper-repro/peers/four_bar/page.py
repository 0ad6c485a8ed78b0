"""Writes `docs/comparison.md` from `page.md` and the results of all libraries: `page.py`, or `page.py NAME …` to print results of some of them.

Every library runs in a process of its own, on one core. A library that is not installed is named as not measured.
"""

import ast
import datetime
import importlib.metadata
import importlib.util
import json
import os
import pathlib
import platform
import subprocess
import sys

import numpy as np

import task

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parents[2] / "docs" / "comparison.md"
CRATE = "hamiltonian-adjoint"
ENTRY = 10  # the knot whose derivative is printed

# Name: (program, module, packages whose versions are printed).
LIBRARIES = {
    CRATE: ("crate_four_bar", "hamiltonian_adjoint", ["hamiltonian-adjoint"]),
    "CasADi": ("casadi_four_bar", "casadi", ["casadi"]),
    "JAX and diffrax": ("diffrax_four_bar", "diffrax", ["jax", "diffrax"]),
    "Pinocchio": ("pinocchio_four_bar", "pinocchio", ["pin"]),
    "MuJoCo": ("mujoco_four_bar", "mujoco", ["mujoco"]),
    "MJX": ("mjx_four_bar", "mujoco.mjx", ["mujoco-mjx"]),
    "Exudyn": ("exudyn_four_bar", "exudyn", ["exudyn"]),
}
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "JAX_PLATFORMS": "cpu",
}


def is_installed(module):
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def run(program):
    """The results of one library, or the last line of its error."""
    one_core = (lambda: os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})) if hasattr(os, "sched_setaffinity") else None
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": str(HERE.parent)}
    done = subprocess.run([sys.executable, HERE / f"{program}.py"], capture_output=True, text=True, env=environment, preexec_fn=one_core)
    if done.returncode:
        return "failed: " + (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1].replace("|", "/")
    return json.loads(done.stdout.strip().splitlines()[-1])


def lines_of_code(program):
    """Lines between `# begin` and `# end` without empty lines, comments and strings that document."""
    source = (HERE / f"{program}.py").read_text(encoding="utf-8")
    documentation = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            documentation.update(range(node.lineno, node.end_lineno + 1))
    count, is_counted = 0, False
    for number, line in enumerate(source.splitlines(), 1):
        if line in ("# begin", "# end"):
            is_counted = line == "# begin"
        elif is_counted and line.strip() and not line.strip().startswith("#") and number not in documentation:
            count += 1
    return count


def error(found, expected):
    """The largest difference, relative to the largest expected entry."""
    found, expected = np.atleast_1d(found), np.atleast_1d(expected)
    return f"{np.abs(found - expected).max() / np.abs(expected).max():.1e}"


def number(x):
    return f"{x:.3g}" if x < 1000 else f"{x:.0f}"


def table(head, rows):
    line = lambda row: "| " + " | ".join(map(str, row)) + " |"
    return "\n".join([line(head), "|" + "---|" * len(head), *map(line, rows)])


def tables(results):
    """The tables of times and errors, and of values."""
    reference = json.loads(task.REFERENCE.read_text(encoding="utf-8"))
    expected = [reference[name] for name in ("J", "dJ/dtorque", "dJ/dlength")]
    values = lambda J, by_torque, by_length: [f"{J:.9f}", f"{np.linalg.norm(by_torque):.9f}", f"{by_torque[ENTRY]:.9f}", f"{by_length:.8f}"]
    speed, digits = [], [["reference", "", *values(*expected)]]
    for name, found in results.items():
        if isinstance(found, str):
            speed.append([name, found, *[""] * 8])
            continue
        for way in found:
            scheme = f"{way['scheme']}, {way['steps']:,} steps"
            solved = way["value"], way["by_torque"], way["by_length"]
            value, both = (1e3 * time for time in way["times"])
            lines = lines_of_code(LIBRARIES[name][0])
            preparation = f"{way['preparation']:.2g}" if way["preparation"] > max(0.1, 0.1 * way["times"][1]) else "–"
            errors = [error(*pair) for pair in zip(solved, expected)]
            speed.append([name, scheme, *errors, number(value), number(both), number(both / value), preparation, lines])
            digits.append([name, scheme, *values(*solved)])
    head = ["library", "scheme", "error of J", "of dJ/dτ", "of dJ/dl", "J, ms", "J and gradient, ms", "ratio", "preparation, s", "lines"]
    return table(head, speed), table(["library", "scheme", "J", "norm of dJ/dτ", f"dJ/dτ at {task.KNOTS[ENTRY]:g} s", "dJ/dl"], digits)


def machine():
    """Date, processor and versions."""
    try:
        model = next(line.split(": ")[1] for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name"))
    except (OSError, StopIteration):
        model = platform.processor() or "unknown processor"
    packages = [package for _, module, packages in LIBRARIES.values() if is_installed(module) for package in packages]
    versions = [f"{package} {importlib.metadata.version(package)}" for package in packages]
    load = f", load average at the start {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    where = f"{platform.system()} {platform.machine()}, {model}, {os.cpu_count()} cores{load}"
    return f"{datetime.date.today()}, {where}; Python {platform.python_version()}, {', '.join(versions)}."


def main(chosen):
    described = machine()
    results = {}
    for name in chosen or LIBRARIES:
        program, module, _ = LIBRARIES[name]
        results[name] = run(program) if is_installed(module) else "not measured: not installed"
        print(name, "done" if not isinstance(results[name], str) else results[name], file=sys.stderr, flush=True)
    speed, digits = tables(results)
    if chosen:
        print(described, speed, digits, sep="\n\n")
        return
    text = (HERE / "page.md").read_text(encoding="utf-8")
    for name, content in {"machine": described, "speed": speed, "digits": digits}.items():
        text = text.replace(f"<!-- {name} -->", content)
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
