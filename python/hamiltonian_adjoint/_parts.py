"""Ready-made parts of a scene. Written by `tools/parts.py`; a test asserts that it is up to date."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ._handles import (
    Control,
    Coordinate,
    Equation,
    Event,
    Frame,
    Ground,
    Joint,
    Marker,
    Motion1D,
    Number,
    Output,
    Particle,
    Point,
    SpaceBody,
    Vector,
)


class Parts:
    """Methods that add ready-made parts. Most return the equations of the part, none if it is no constraint."""

    def _ready(self, kind: str, name: str | Event, given: dict[str, Any]) -> Any:
        raise NotImplementedError

    def revolute(self, name: str, a: Point | Particle, b: Point | Particle) -> Joint:
        """Adds a part of the kind 'revolute'."""
        return self._ready("revolute", name, {"a": a, "b": b})

    def prismatic(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, angle: Number) -> Joint:
        """Adds a part of the kind 'prismatic'. Units: axis in rad, angle in rad."""
        return self._ready("prismatic", name, {"a": a, "b": b, "axis": axis, "angle": angle})

    def weld(self, name: str, a: Point | Particle, b: Point | Particle, angle: Number) -> Joint:
        """Adds a part of the kind 'weld'. Units: angle in rad."""
        return self._ready("weld", name, {"a": a, "b": b, "angle": angle})

    def distance(self, name: str, a: Point | Particle, b: Point | Particle, length: Number) -> Joint:
        """Adds a part of the kind 'distance'. Units: length in m."""
        return self._ready("distance", name, {"a": a, "b": b, "length": length})

    def driven_angle(self, name: str, a: Frame, b: Frame, motion: Motion1D) -> Joint:
        """Adds a part of the kind 'driven angle'."""
        return self._ready("driven angle", name, {"a": a, "b": b, "motion": motion})

    def driven_distance(self, name: str, a: Point | Particle, b: Point | Particle, motion: Motion1D) -> Joint:
        """Adds a part of the kind 'driven distance'."""
        return self._ready("driven distance", name, {"a": a, "b": b, "motion": motion})

    def driven_slider(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, motion: Motion1D) -> Joint:
        """Adds a part of the kind 'driven slider'. Units: axis in rad."""
        return self._ready("driven slider", name, {"a": a, "b": b, "axis": axis, "motion": motion})

    def two_point_actuator(self, name: str, a: Point | Particle, b: Point | Particle, force: Control) -> Joint:
        """Adds a part of the kind 'two-point actuator'."""
        return self._ready("two-point actuator", name, {"a": a, "b": b, "force": force})

    def applied_force(self, name: str, at: Point | Particle, direction: Number, motion: Motion1D) -> Joint:
        """Adds a part of the kind 'applied force'. Units: direction in rad."""
        return self._ready("applied force", name, {"at": at, "direction": direction, "motion": motion})

    def applied_torque(self, name: str, body: Frame, motion: Motion1D) -> Joint:
        """Adds a part of the kind 'applied torque'."""
        return self._ready("applied torque", name, {"body": body, "motion": motion})

    def spring_damper(self, name: str, a: Point | Particle, b: Point | Particle, stiffness: Number, free_length: Number, damping: Number) -> Joint:
        """Adds a part of the kind 'spring and damper'. Units: free_length in m."""
        return self._ready("spring and damper", name, {"a": a, "b": b, "stiffness": stiffness, "free_length": free_length, "damping": damping})

    def torsional_spring_damper(self, name: str, a: Frame, b: Frame, stiffness: Number, free_angle: Number, damping: Number) -> Joint:
        """Adds a part of the kind 'torsional spring and damper'. Units: free_angle in rad."""
        return self._ready("torsional spring and damper", name, {"a": a, "b": b, "stiffness": stiffness, "free_angle": free_angle, "damping": damping})

    def joint_friction(self, name: str, a: Frame, b: Frame, damping: Number) -> Joint:
        """Adds a part of the kind 'joint friction'."""
        return self._ready("joint friction", name, {"a": a, "b": b, "damping": damping})

    def sliding_friction(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, damping: Number) -> Joint:
        """Adds a part of the kind 'sliding friction'. Units: axis in rad."""
        return self._ready("sliding friction", name, {"a": a, "b": b, "axis": axis, "damping": damping})

    def actuator(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, force: Control) -> Joint:
        """Adds a part of the kind 'actuator'. Units: axis in rad."""
        return self._ready("actuator", name, {"a": a, "b": b, "axis": axis, "force": force})

    def torque_actuator(self, name: str, a: Frame, b: Frame, torque: Control) -> Joint:
        """Adds a part of the kind 'torque actuator'."""
        return self._ready("torque actuator", name, {"a": a, "b": b, "torque": torque})

    def bushing(
        self,
        name: str,
        a: Point | Particle,
        b: Point | Particle,
        stiffness_x: Number,
        stiffness_y: Number,
        stiffness_angle: Number,
        damping_x: Number,
        damping_y: Number,
        damping_angle: Number,
    ) -> Joint:
        """Adds a part of the kind 'bushing'. Units: stiffness_x in N/m, stiffness_y in N/m, stiffness_angle in N m/rad, damping_x in N s/m, damping_y in N s/m, damping_angle in N m s/rad."""
        return self._ready("bushing", name, {"a": a, "b": b, "stiffness_x": stiffness_x, "stiffness_y": stiffness_y, "stiffness_angle": stiffness_angle, "damping_x": damping_x, "damping_y": damping_y, "damping_angle": damping_angle})

    def coulomb_friction(self, name: str, a: Frame, b: Frame, torque: Number, speed: Number) -> Joint:
        """Adds a part of the kind 'Coulomb friction'. Units: torque in N m."""
        return self._ready("Coulomb friction", name, {"a": a, "b": b, "torque": torque, "speed": speed})

    def coulomb_sliding_friction(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, force: Number, speed: Number) -> Joint:
        """Adds a part of the kind 'Coulomb sliding friction'. Units: axis in rad, force in N."""
        return self._ready("Coulomb sliding friction", name, {"a": a, "b": b, "axis": axis, "force": force, "speed": speed})

    def rigid_contact(self, name: str, a: Point | Particle, b: Point | Particle, normal: Number) -> Joint:
        """Adds a part of the kind 'rigid contact'. Units: normal in rad."""
        return self._ready("rigid contact", name, {"a": a, "b": b, "normal": normal})

    def contact(
        self,
        name: str,
        a: Point | Particle,
        b: Point | Particle,
        normal: Number,
        stiffness: Number,
        damping: Number,
        friction: Number,
        speed: Number,
    ) -> Joint:
        """Adds a part of the kind 'contact'. Units: normal in rad."""
        return self._ready("contact", name, {"a": a, "b": b, "normal": normal, "stiffness": stiffness, "damping": damping, "friction": friction, "speed": speed})

    def circle_contact(
        self,
        name: str,
        a: Point | Particle,
        b: Point | Particle,
        normal: Number,
        radius: Number,
        stiffness: Number,
        damping: Number,
        friction: Number,
        speed: Number,
        width: Number,
    ) -> Joint:
        """Adds a part of the kind 'circle contact'. Units: normal in rad, radius in m, width in m."""
        return self._ready("circle contact", name, {"a": a, "b": b, "normal": normal, "radius": radius, "stiffness": stiffness, "damping": damping, "friction": friction, "speed": speed, "width": width})

    def contact_of_circles(
        self,
        name: str,
        a: Point | Particle,
        b: Point | Particle,
        radius_a: Number,
        radius_b: Number,
        stiffness: Number,
        damping: Number,
        friction: Number,
        speed: Number,
        width: Number,
    ) -> Joint:
        """Adds a part of the kind 'contact of circles'. Units: radius_a in m, radius_b in m, width in m."""
        return self._ready("contact of circles", name, {"a": a, "b": b, "radius_a": radius_a, "radius_b": radius_b, "stiffness": stiffness, "damping": damping, "friction": friction, "speed": speed, "width": width})

    def end_stop(self, name: str, a: Frame, b: Frame, lower: Number, upper: Number, stiffness: Number, damping: Number, width: Number) -> Joint:
        """Adds a part of the kind 'end stop'. Units: width in m."""
        return self._ready("end stop", name, {"a": a, "b": b, "lower": lower, "upper": upper, "stiffness": stiffness, "damping": damping, "width": width})

    def sliding_end_stop(
        self,
        name: str,
        a: Point | Particle,
        b: Point | Particle,
        axis: Number,
        lower: Number,
        upper: Number,
        stiffness: Number,
        damping: Number,
        width: Number,
    ) -> Joint:
        """Adds a part of the kind 'sliding end stop'. Units: axis in rad, width in m."""
        return self._ready("sliding end stop", name, {"a": a, "b": b, "axis": axis, "lower": lower, "upper": upper, "stiffness": stiffness, "damping": damping, "width": width})

    def gear(self, name: str, a: Frame, b: Frame, radius_a: Number, radius_b: Number) -> Joint:
        """Adds a part of the kind 'gear'. Units: radius_a in m, radius_b in m."""
        return self._ready("gear", name, {"a": a, "b": b, "radius_a": radius_a, "radius_b": radius_b})

    def rack(self, name: str, rack: Frame, pinion: Frame, axis: Number, radius: Number) -> Joint:
        """Adds a part of the kind 'rack'. Units: axis in rad, radius in m."""
        return self._ready("rack", name, {"rack": rack, "pinion": pinion, "axis": axis, "radius": radius})

    def drawn_spring(self, name: str, a: Point | Particle, b: Point | Particle) -> Joint:
        """Adds a part of the kind 'drawn spring'."""
        return self._ready("drawn spring", name, {"a": a, "b": b})

    def drawn_rod(self, name: str, a: Point | Particle, b: Point | Particle) -> Joint:
        """Adds a part of the kind 'drawn rod'."""
        return self._ready("drawn rod", name, {"a": a, "b": b})

    def body_in_space(
        self,
        name: str,
        mass: Number,
        inertia: Vector,
        centre: Vector | None = None,
        lengths: Vector | None = None,
        unchecked: bool | None = None,
    ) -> SpaceBody:
        """Adds a part of the kind 'body in space'."""
        return self._ready("body in space", name, {"mass": mass, "inertia": inertia, "centre": centre, "lengths": lengths, "unchecked": unchecked})

    def planar_body(self, name: str, body: Frame) -> SpaceBody:
        """Adds a part of the kind 'planar body'."""
        return self._ready("planar body", name, {"body": body})

    def revolute_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'revolute in space'."""
        return self._ready("revolute in space", name, {"a": a, "b": b})

    def prismatic_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'prismatic in space'."""
        return self._ready("prismatic in space", name, {"a": a, "b": b})

    def dependent_revolute(
        self,
        name: str,
        a: Marker | SpaceBody | Ground,
        b: Marker | SpaceBody | Ground,
        factor: Number,
        offset: Number,
        of: Coordinate,
    ) -> Joint:
        """Adds a part of the kind 'dependent revolute'."""
        return self._ready("dependent revolute", name, {"a": a, "b": b, "factor": factor, "offset": offset, "of": of})

    def dependent_prismatic(
        self,
        name: str,
        a: Marker | SpaceBody | Ground,
        b: Marker | SpaceBody | Ground,
        factor: Number,
        offset: Number,
        of: Coordinate,
    ) -> Joint:
        """Adds a part of the kind 'dependent prismatic'."""
        return self._ready("dependent prismatic", name, {"a": a, "b": b, "factor": factor, "offset": offset, "of": of})

    def universal(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'universal'."""
        return self._ready("universal", name, {"a": a, "b": b})

    def cylindrical(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'cylindrical'."""
        return self._ready("cylindrical", name, {"a": a, "b": b})

    def planar_joint(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'planar joint'."""
        return self._ready("planar joint", name, {"a": a, "b": b})

    def fixed(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'fixed'."""
        return self._ready("fixed", name, {"a": a, "b": b})

    def load_cell(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'load cell'."""
        return self._ready("load cell", name, {"a": a, "b": b})

    def ball(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'ball'."""
        return self._ready("ball", name, {"a": a, "b": b})

    def free(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'free'."""
        return self._ready("free", name, {"a": a, "b": b})

    def cut(self, name: str, body: SpaceBody) -> Joint:
        """Adds a part of the kind 'cut'."""
        return self._ready("cut", name, {"body": body})

    def close_ball(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'close ball'."""
        return self._ready("close ball", name, {"a": a, "b": b})

    def close_parallel(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'close parallel'."""
        return self._ready("close parallel", name, {"a": a, "b": b})

    def close_revolute(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'close revolute'."""
        return self._ready("close revolute", name, {"a": a, "b": b})

    def close_cylindrical(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'close cylindrical'."""
        return self._ready("close cylindrical", name, {"a": a, "b": b})

    def close_prismatic(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'close prismatic'."""
        return self._ready("close prismatic", name, {"a": a, "b": b})

    def close_fixed(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'close fixed'."""
        return self._ready("close fixed", name, {"a": a, "b": b})

    def point_on_plane(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'point on plane'."""
        return self._ready("point on plane", name, {"a": a, "b": b})

    def point_on_line(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a part of the kind 'point on line'."""
        return self._ready("point on line", name, {"a": a, "b": b})

    def distance_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, length: Number) -> Joint:
        """Adds a part of the kind 'distance in space'. Units: length in m."""
        return self._ready("distance in space", name, {"a": a, "b": b, "length": length})

    def driven_distance_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, motion: Motion1D) -> Joint:
        """Adds a part of the kind 'driven distance in space'."""
        return self._ready("driven distance in space", name, {"a": a, "b": b, "motion": motion})

    def thrust(self, name: str, marker: Marker | SpaceBody | Ground, force: Control) -> Joint:
        """Adds a part of the kind 'thrust'."""
        return self._ready("thrust", name, {"marker": marker, "force": force})

    def torque_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, torque: Control) -> Joint:
        """Adds a part of the kind 'torque in space'."""
        return self._ready("torque in space", name, {"a": a, "b": b, "torque": torque})

    def applied_in_space(self, name: str, marker: Marker | SpaceBody | Ground, force: Vector, torque: Vector) -> Joint:
        """Adds a part of the kind 'applied in space'."""
        return self._ready("applied in space", name, {"marker": marker, "force": force, "torque": torque})

    def applied_on_body(self, name: str, marker: Marker | SpaceBody | Ground, force: Vector, torque: Vector) -> Joint:
        """Adds a part of the kind 'applied on body'."""
        return self._ready("applied on body", name, {"marker": marker, "force": force, "torque": torque})

    def two_point_actuator_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, force: Control) -> Joint:
        """Adds a part of the kind 'two-point actuator in space'."""
        return self._ready("two-point actuator in space", name, {"a": a, "b": b, "force": force})

    def spring_damper_in_space(
        self,
        name: str,
        a: Marker | SpaceBody | Ground,
        b: Marker | SpaceBody | Ground,
        stiffness: Number,
        free_length: Number,
        damping: Number,
    ) -> Joint:
        """Adds a part of the kind 'spring and damper in space'. Units: free_length in m."""
        return self._ready("spring and damper in space", name, {"a": a, "b": b, "stiffness": stiffness, "free_length": free_length, "damping": damping})

    def outputs_of_a_marker(self, name: str, marker: Marker | SpaceBody | Ground, quantity: str, sum: str | dict[str, int]) -> Joint:
        """Adds a part of the kind 'outputs of a marker'."""
        return self._ready("outputs of a marker", name, {"marker": marker, "quantity": quantity, "sum": sum})

    def rotation_error(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, sum: str | dict[str, int]) -> Joint:
        """Adds a part of the kind 'rotation error'."""
        return self._ready("rotation error", name, {"a": a, "b": b, "sum": sum})

    def motor(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], force: Control) -> Joint:
        """Adds a part of the kind 'motor'."""
        return self._ready("motor", name, {"axis": axis, "force": force})

    def axis_force(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], motion: Motion1D) -> Joint:
        """Adds a part of the kind 'axis force'."""
        return self._ready("axis force", name, {"axis": axis, "motion": motion})

    def axis_spring_damper(
        self,
        name: str,
        axis: Coordinate | Mapping[Coordinate, Number],
        stiffness: Number,
        free_value: Number,
        damping: Number,
    ) -> Joint:
        """Adds a part of the kind 'axis spring and damper'."""
        return self._ready("axis spring and damper", name, {"axis": axis, "stiffness": stiffness, "free_value": free_value, "damping": damping})

    def axis_coulomb_friction(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], force: Number, speed: Number) -> Joint:
        """Adds a part of the kind 'axis Coulomb friction'. Units: force in N."""
        return self._ready("axis Coulomb friction", name, {"axis": axis, "force": force, "speed": speed})

    def axis_end_stop(
        self,
        name: str,
        axis: Coordinate | Mapping[Coordinate, Number],
        lower: Number,
        upper: Number,
        stiffness: Number,
        damping: Number,
        width: Number,
    ) -> Joint:
        """Adds a part of the kind 'axis end stop'. Units: width in m."""
        return self._ready("axis end stop", name, {"axis": axis, "lower": lower, "upper": upper, "stiffness": stiffness, "damping": damping, "width": width})

    def rotor(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], inertia: Number, ratio: Number) -> Joint:
        """Adds a part of the kind 'rotor'."""
        return self._ready("rotor", name, {"axis": axis, "inertia": inertia, "ratio": ratio})

    def driven_axis(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], motion: Motion1D) -> Joint:
        """Adds a part of the kind 'driven axis'."""
        return self._ready("driven axis", name, {"axis": axis, "motion": motion})

    def linear_relation(self, name: str, terms: Coordinate | Mapping[Coordinate, Number], c: Number) -> Joint:
        """Adds a part of the kind 'linear relation'."""
        return self._ready("linear relation", name, {"terms": terms, "c": c})

    def open_at_event(self, event: Event, equations: Iterable[Equation]) -> Joint:
        """Adds a part of the kind 'open at event'."""
        return self._ready("open at event", event, {"equations": equations})

    def close_at_event(self, event: Event, equations: Iterable[Equation]) -> Joint:
        """Adds a part of the kind 'close at event'."""
        return self._ready("close at event", event, {"equations": equations})

    def hold_at_event(self, event: Event, equations: Iterable[Equation]) -> Joint:
        """Adds a part of the kind 'hold at event'."""
        return self._ready("hold at event", event, {"equations": equations})

    def impact_at_event(self, event: Event, restitution: Number, equation: Equation) -> Joint:
        """Adds a part of the kind 'impact at event'."""
        return self._ready("impact at event", event, {"restitution": restitution, "equation": equation})

    def reaction_event(self, name: str, equation: Equation) -> Event:
        """Adds a part of the kind 'reaction event'."""
        return self._ready("reaction event", name, {"equation": equation})

    def event_time(self, name: str, event: int) -> Output:
        """Adds a part of the kind 'event time'."""
        return self._ready("event time", name, {"event": event})

    def event_impulse(self, name: str, equation: Equation, event: int) -> Output:
        """Adds a part of the kind 'event impulse'."""
        return self._ready("event impulse", name, {"equation": equation, "event": event})
