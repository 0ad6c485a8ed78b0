"""Functions of time for driven parts."""

from __future__ import annotations

from ._handles import Number


class Motion1D:
    """A function of time for driven parts."""

    def __init__(self, kind: str, *parameters: Number) -> None:
        self.kind, self.parameters = kind, parameters


def constant(value: Number) -> Motion1D:
    """The function with a constant value."""
    return Motion1D("constant", value)


def constant_speed(start: Number, speed: Number) -> Motion1D:
    """The function start + speed t."""
    return Motion1D("constant speed", start, speed)


def harmonic(mean: Number, amplitude: Number, frequency: Number, phase: Number = 0.0) -> Motion1D:
    """The function mean + amplitude sin(frequency t + phase), with the frequency in rad/s."""
    return Motion1D("harmonic", mean, amplitude, frequency, phase)
