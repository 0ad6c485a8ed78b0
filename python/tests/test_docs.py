"""The examples of the guide and of the package."""

import doctest
import pathlib
import re
import warnings

import hamiltonian_adjoint as ha

GUIDE = pathlib.Path(__file__).parent.parent.parent / "docs" / "python.md"

OPTIONAL = ("casadi", "cyipopt")


def test_the_guide(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 18
    names: dict[str, object] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ha.MotionWarning)
        for block in blocks:
            try:
                exec(block, names)
            except ModuleNotFoundError as missing:
                assert missing.name in OPTIONAL
    assert (tmp_path / "arm.html").stat().st_size > 10_000


def test_the_package():
    tested = doctest.testmod(ha)
    assert tested.attempted > 10 and tested.failed == 0
