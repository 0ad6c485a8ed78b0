"""Ready-made parts of a scene. Written by `tools/parts.py`; a test asserts that it is up to date."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ._functions_of_time import Motion1D
from ._handles import (
    Control,
    Coordinate,
    Equation,
    Event,
    Frame,
    Ground,
    Joint,
    Marker,
    Number,
    Output,
    Particle,
    Point,
    SpaceBody,
    Vector,
)


class Parts:
    """Methods that add ready-made parts. Those of joints and constraints return their equations and coordinates."""

    def _ready(self, kind: str, name: str | Event, given: dict[str, Any]) -> Any:
        raise NotImplementedError

    def revolute(self, name: str, a: Point | Particle, b: Point | Particle) -> Joint:
        """Adds a hinge: the points a and b coincide.

        Two equations.
        """
        return self._ready("revolute", name, {"a": a, "b": b})

    def prismatic(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, angle: Number) -> Joint:
        """Adds a slider: the point b moves along a line through the point a and does not turn relative to a.

        `axis` is the angle of the line in the frame of a, rad; `angle` is φ_b − φ_a, rad. Two equations.
        """
        return self._ready("prismatic", name, {"a": a, "b": b, "axis": axis, "angle": angle})

    def weld(self, name: str, a: Point | Particle, b: Point | Particle, angle: Number) -> Joint:
        """Adds a rigid connection of two points.

        `angle` is φ_b − φ_a, rad. Three equations.
        """
        return self._ready("weld", name, {"a": a, "b": b, "angle": angle})

    def distance(self, name: str, a: Point | Particle, b: Point | Particle, length: Number) -> Joint:
        """Adds a rod without mass: two points keep a distance.

        `length`, m. One equation; the points must not coincide.
        """
        return self._ready("distance", name, {"a": a, "b": b, "length": length})

    def driven_angle(self, name: str, a: Frame, b: Frame, motion: Motion1D) -> Joint:
        """Adds a prescribed angle φ_b − φ_a.

        `motion` is constant(…), constant_speed(…) or harmonic(…), rad. One equation.
        """
        return self._ready("driven angle", name, {"a": a, "b": b, "motion": motion})

    def driven_distance(self, name: str, a: Point | Particle, b: Point | Particle, motion: Motion1D) -> Joint:
        """Adds a prescribed distance between two points, as of a cylinder.

        `motion` is constant(…), constant_speed(…) or harmonic(…), m, and positive. One equation.
        """
        return self._ready("driven distance", name, {"a": a, "b": b, "motion": motion})

    def driven_slider(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, motion: Motion1D) -> Joint:
        """Adds a prescribed position of the point b along an axis of a.

        `axis` is the angle of the direction in the frame of a, rad. `motion` is constant(…), constant_speed(…) or harmonic(…), m. One equation.
        """
        return self._ready("driven slider", name, {"a": a, "b": b, "axis": axis, "motion": motion})

    def two_point_actuator(self, name: str, a: Point | Particle, b: Point | Particle, force: Control) -> None:
        """Adds a force u along the line between two points, which pushes them apart if it is positive.

        `force` is the control u, N. The points must not coincide.
        """
        self._ready("two-point actuator", name, {"a": a, "b": b, "force": force})

    def applied_force(self, name: str, at: Point | Particle, direction: Number, motion: Motion1D) -> None:
        """Adds a prescribed force at a point of a body.

        `direction` is an angle in the inertial frame, rad. `motion` is constant(…), constant_speed(…) or harmonic(…), N.
        """
        self._ready("applied force", name, {"at": at, "direction": direction, "motion": motion})

    def applied_torque(self, name: str, body: Frame, motion: Motion1D) -> None:
        """Adds a prescribed torque on a body.

        `motion` is constant(…), constant_speed(…) or harmonic(…), N m.
        """
        self._ready("applied torque", name, {"body": body, "motion": motion})

    def spring_damper(self, name: str, a: Point | Particle, b: Point | Particle, stiffness: Number, free_length: Number, damping: Number) -> None:
        """Adds a spring and a damper along the line between two points with the distance l: the force k (l − l₀) + d dl/dt pulls them together.

        `stiffness` k, N/m; `free_length` l₀, m; `damping` d, N s/m. The points must not coincide, unless free length and damping are 0.
        """
        self._ready("spring and damper", name, {"a": a, "b": b, "stiffness": stiffness, "free_length": free_length, "damping": damping})

    def torsional_spring_damper(self, name: str, a: Frame, b: Frame, stiffness: Number, free_angle: Number, damping: Number) -> None:
        """Adds a spring and a damper of the relative angle φ = φ_b − φ_a: the torque −k (φ − φ₀) − d dφ/dt acts on b, and its reaction on a.

        `stiffness` k, N m/rad; `free_angle` φ₀, rad; `damping` d, N m s/rad.
        """
        self._ready("torsional spring and damper", name, {"a": a, "b": b, "stiffness": stiffness, "free_angle": free_angle, "damping": damping})

    def joint_friction(self, name: str, a: Frame, b: Frame, damping: Number) -> None:
        """Adds viscous friction against the relative rotation ω = dφ_b/dt − dφ_a/dt: the torque −d ω on b, and its reaction on a.

        `damping` d, N m s/rad.
        """
        self._ready("joint friction", name, {"a": a, "b": b, "damping": damping})

    def sliding_friction(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, damping: Number) -> None:
        """Adds viscous friction of the point b along an axis of a: the force −d ds/dt on b, and its reaction on a.

        `axis` is the angle of the direction in the frame of a, rad. `damping` d, N s/m.
        """
        self._ready("sliding friction", name, {"a": a, "b": b, "axis": axis, "damping": damping})

    def actuator(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, force: Control) -> None:
        """Adds a force u on the point b along an axis of a, and its reaction on a.

        `axis` is the angle of the direction in the frame of a, rad. `force` is the control u, N.
        """
        self._ready("actuator", name, {"a": a, "b": b, "axis": axis, "force": force})

    def torque_actuator(self, name: str, a: Frame, b: Frame, torque: Control) -> None:
        """Adds a torque u on b, and its reaction on a.

        `torque` is the control u, N m.
        """
        self._ready("torque actuator", name, {"a": a, "b": b, "torque": torque})

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
    ) -> None:
        """Adds an elastic connection of two points: springs and dampers along x and y of the frame of a, and against the relative rotation.

        `stiffness_x` and `stiffness_y`, N/m; `stiffness_angle`, N m/rad; `damping_x` and `damping_y`, N s/m; `damping_angle`, N m s/rad.
        """
        self._ready("bushing", name, {"a": a, "b": b, "stiffness_x": stiffness_x, "stiffness_y": stiffness_y, "stiffness_angle": stiffness_angle, "damping_x": damping_x, "damping_y": damping_y, "damping_angle": damping_angle})

    def coulomb_friction(self, name: str, a: Frame, b: Frame, torque: Number, speed: Number) -> None:
        """Adds dry friction in a hinge, regularised: the torque −M tanh(ω/ω_s) on b with ω = dφ_b/dt − dφ_a/dt, and its reaction on a.

        `torque` M, N m; `speed` ω_s, rad/s, near which the friction changes its sign. There is no sticking; a small speed is stiff and needs an
        L-stable scheme.
        """
        self._ready("Coulomb friction", name, {"a": a, "b": b, "torque": torque, "speed": speed})

    def coulomb_sliding_friction(self, name: str, a: Point | Particle, b: Point | Particle, axis: Number, force: Number, speed: Number) -> None:
        """Adds dry friction of the point b along an axis of a, regularised: the force −F tanh((ds/dt)/v_s) on b, and its reaction on a.

        `axis` is the angle of the direction in the frame of a, rad. `force` F, N; `speed` v_s, m/s, near which the friction changes its sign. There
        is no sticking.
        """
        self._ready("Coulomb sliding friction", name, {"a": a, "b": b, "axis": axis, "force": force, "speed": speed})

    def rigid_contact(self, name: str, a: Point | Particle, b: Point | Particle, normal: Number) -> Joint:
        """Adds the gap between the point b and a line through the point a, as an equation and as an event of this name (scene.find(name, 'event')).

        `normal` is the direction of the outer normal in the frame of a, rad. What the event does is added by impact_at_event, close_at_event or
        open_at_event; otherwise the equation always holds.
        """
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
    ) -> Event:
        """Adds the contact of the point b with a half-plane through the point a: at the depth δ > 0, the normal force N = k δ^(3/2) max(1 + c dδ/dt, 0) and
        the friction −μ N tanh(v/v_s).

        `normal` is the direction of the outer normal in the frame of a, rad; `stiffness` k, N/m^(3/2); `damping` c, s/m; `friction` is the
        coefficient μ, and `speed` v_s, m/s, smooths the friction near rest (there is no sticking). Returns the event that the gap is zero. Steps must
        resolve the contact.
        """
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
    ) -> None:
        """Adds the contact of a circle about the point b with a half-plane through the point a: at the depth δ > 0, the normal force N = k δ^(3/2) max(1 + c
        dδ/dt, 0) and the friction −μ N tanh(v/v_s).

        `normal` is the direction of the outer normal in the frame of a, rad; `radius`, m; `stiffness` k, N/m^(3/2); `damping` c, s/m; `friction` is
        the coefficient μ, and `speed` v_s, m/s, smooths the friction near rest (there is no sticking). The force begins smoothly over the `width`, m,
        which ten or more steps should cross. If it is the number 0, the force begins with a kink, and the part is an event, too: scene.find(name,
        'event').
        """
        self._ready("circle contact", name, {"a": a, "b": b, "normal": normal, "radius": radius, "stiffness": stiffness, "damping": damping, "friction": friction, "speed": speed, "width": width})

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
    ) -> None:
        """Adds the contact of circles about the points a and b: at the depth δ > 0, the normal force N = k δ^(3/2) max(1 + c dδ/dt, 0) and the friction −μ N
        tanh(v/v_s).

        `radius_a` and `radius_b`, m; a negative `radius_a` is that of a bore around the circle of b. `stiffness` k, N/m^(3/2); `damping` c, s/m;
        `friction` is the coefficient μ, and `speed` v_s, m/s, smooths the friction near rest (there is no sticking). The force begins smoothly over
        the `width`, m, which ten or more steps should cross. If it is the number 0, the force begins with a kink, and the part is an event, too:
        scene.find(name, 'event').
        """
        self._ready("contact of circles", name, {"a": a, "b": b, "radius_a": radius_a, "radius_b": radius_b, "stiffness": stiffness, "damping": damping, "friction": friction, "speed": speed, "width": width})

    def end_stop(self, name: str, a: Frame, b: Frame, lower: Number, upper: Number, stiffness: Number, damping: Number, width: Number) -> None:
        """Adds stops of the relative angle φ_b − φ_a.

        Beyond a limit by δ > 0, the torque k δ max(1 + c dδ/dt, 0) acts on b toward the range, and its reaction on a. `lower` and `upper`, rad;
        `stiffness` k, N m/rad; `damping` c, s/rad. `width`, rad, is the depth over which it begins smoothly; with the number 0 the part is an event,
        too: scene.find(name, 'event').
        """
        self._ready("end stop", name, {"a": a, "b": b, "lower": lower, "upper": upper, "stiffness": stiffness, "damping": damping, "width": width})

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
    ) -> None:
        """Adds stops of the position of the point b along an axis of a, which is 0 at the point a.

        Beyond a limit by δ > 0, the force k δ max(1 + c dδ/dt, 0) acts on b toward the range, and its reaction on a. `axis` is the angle of the
        direction in the frame of a, rad. `lower` and `upper`, m; `stiffness` k, N/m; `damping` c, s/m. `width`, m, is the depth over which it begins
        smoothly; with the number 0 the part is an event, too: scene.find(name, 'event').
        """
        self._ready("sliding end stop", name, {"a": a, "b": b, "axis": axis, "lower": lower, "upper": upper, "stiffness": stiffness, "damping": damping, "width": width})

    def gear(self, name: str, a: Frame, b: Frame, radius_a: Number, radius_b: Number) -> Joint:
        """Adds two wheels that roll on each other, from their initial angles, in opposite directions.

        `radius_a` and `radius_b`, m; a negative one is that of a ring gear around the other wheel. The axles must be fixed by revolute joints. One
        equation.
        """
        return self._ready("gear", name, {"a": a, "b": b, "radius_a": radius_a, "radius_b": radius_b})

    def rack(self, name: str, rack: Frame, pinion: Frame, axis: Number, radius: Number) -> Joint:
        """Adds a rack along which a wheel rolls, from their initial positions.

        `axis` is the direction of the rack in the inertial frame, rad; `radius` is that of the pinion, m. One equation.
        """
        return self._ready("rack", name, {"rack": rack, "pinion": pinion, "axis": axis, "radius": radius})

    def drawn_spring(self, name: str, a: Point | Particle, b: Point | Particle) -> None:
        """Draws a spring between two points in pictures.

        It has no effect on the motion.
        """
        self._ready("drawn spring", name, {"a": a, "b": b})

    def drawn_rod(self, name: str, a: Point | Particle, b: Point | Particle) -> None:
        """Draws a rod between two points in pictures.

        It has no effect on the motion.
        """
        self._ready("drawn rod", name, {"a": a, "b": b})

    def body_in_space(
        self,
        name: str,
        mass: Number,
        inertia: Vector,
        centre: Vector | None = None,
        lengths: Vector | None = None,
        unchecked: bool | None = None,
    ) -> SpaceBody:
        """Adds a rigid body in space, which a joint must carry.

        `mass`, kg; `inertia` J_xx, J_yy, J_zz, J_xy, J_xz, J_yz about the centre of mass along the axes of the body, kg m², with J_xy = −∫ x y dm;
        `centre` is the centre of mass in the frame of the body, m, by default its origin; `lengths` are the edges of a cuboid, m, that must not be
        negative; `unchecked` accepts moments of inertia that no body can have.
        """
        return self._ready("body in space", name, {"mass": mass, "inertia": inertia, "centre": centre, "lengths": lengths, "unchecked": unchecked})

    def planar_body(self, name: str, body: Frame) -> SpaceBody:
        """Adds a body in the plane as a body in space, for joints that carry bodies in space and for markers."""
        return self._ready("planar body", name, {"body": body})

    def revolute_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a hinge: b turns relative to a about their common z axis.

        Its coordinate is the attribute `angle`, rad.
        """
        return self._ready("revolute in space", name, {"a": a, "b": b})

    def prismatic_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a slider: b moves relative to a along their common z axis.

        Its coordinate is the attribute `offset`, m.
        """
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
        """Adds a hinge whose angle is factor · q + offset, as of a gear.

        `of` is the coordinate q of another joint; `factor` and `offset`, rad.
        """
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
        """Adds a slider whose displacement is factor · q + offset, as of a rack.

        `of` is the coordinate q of another joint; `factor` and `offset`, m.
        """
        return self._ready("dependent prismatic", name, {"a": a, "b": b, "factor": factor, "offset": offset, "of": of})

    def universal(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a universal joint: b turns relative to a about the x axis of a, then about its own y axis.

        Its coordinates are scene['name.first angle'] and scene['name.second angle'], rad.
        """
        return self._ready("universal", name, {"a": a, "b": b})

    def cylindrical(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a cylindrical joint: b moves along and turns about the common z axis.

        Its coordinates are the attributes `offset`, m, and `angle`, rad.
        """
        return self._ready("cylindrical", name, {"a": a, "b": b})

    def planar_joint(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a planar joint: b moves in the x–y plane of a and turns about its z axis.

        Its coordinates are the attributes `x` and `y`, m, and `angle`, rad.
        """
        return self._ready("planar joint", name, {"a": a, "b": b})

    def fixed(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a joint that fixes b to a, so that both move as one."""
        return self._ready("fixed", name, {"a": a, "b": b})

    def load_cell(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a joint that fixes b to a and measures: the reactions of its six equations are the force and the torque that it transmits.

        Read them as cell[0].lam … cell[5].lam in costs and outputs.
        """
        return self._ready("load cell", name, {"a": a, "b": b})

    def ball(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a ball joint.

        Its coordinates are the Euler parameters e0, e1, e2, e3, the scalar first, with one equation |e| = 1.
        """
        return self._ready("ball", name, {"a": a, "b": b})

    def free(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a joint that lets b move freely relative to a.

        Its coordinates are x, y, z, m, and the Euler parameters e0, e1, e2, e3, the scalar first.
        """
        return self._ready("free", name, {"a": a, "b": b})

    def cut(self, name: str, body: SpaceBody) -> None:
        """Adds a cut of a long chain of joints at a body, which makes steps faster and does not change the motion.

        Cut chains of more than about 50 joints at every sixth body. Parts that are attached later belong to the second half.
        """
        self._ready("cut", name, {"body": body})

    def close_ball(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a loop that is closed by a ball joint.

        Three equations: the markers coincide. Their reactions are forces along the axes of a, N.
        """
        return self._ready("close ball", name, {"a": a, "b": b})

    def close_parallel(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a constraint by which the z axes of two markers are parallel.

        Two equations, x_a·z_b = y_a·z_b = 0.
        """
        return self._ready("close parallel", name, {"a": a, "b": b})

    def close_revolute(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a loop that is closed by a hinge about the common z axis.

        Five equations: those of close_ball and close_parallel.
        """
        return self._ready("close revolute", name, {"a": a, "b": b})

    def close_cylindrical(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a loop that is closed by a slider along and about the common z axis.

        Four equations: those of point_on_line and close_parallel.
        """
        return self._ready("close cylindrical", name, {"a": a, "b": b})

    def close_prismatic(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a loop that is closed by a slider along the common z axis.

        Five equations: those of close_cylindrical, and x_a·y_b = 0.
        """
        return self._ready("close prismatic", name, {"a": a, "b": b})

    def close_fixed(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a loop that is closed by a weld.

        Six equations: those of close_revolute, and x_a·y_b = 0.
        """
        return self._ready("close fixed", name, {"a": a, "b": b})

    def point_on_plane(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a constraint by which b stays in the x–y plane of a.

        One equation.
        """
        return self._ready("point on plane", name, {"a": a, "b": b})

    def point_on_line(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground) -> Joint:
        """Adds a constraint by which b stays on the z axis of a.

        Two equations.
        """
        return self._ready("point on line", name, {"a": a, "b": b})

    def distance_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, length: Number) -> Joint:
        """Adds a rod without mass: two markers keep a distance.

        `length`, m. One equation, whose reaction is the tension of the rod, N.
        """
        return self._ready("distance in space", name, {"a": a, "b": b, "length": length})

    def driven_distance_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, motion: Motion1D) -> Joint:
        """Adds a prescribed distance of two markers, as of a ram.

        `motion` is constant(…), constant_speed(…) or harmonic(…), m, and positive. One equation.
        """
        return self._ready("driven distance in space", name, {"a": a, "b": b, "motion": motion})

    def thrust(self, name: str, marker: Marker | SpaceBody | Ground, force: Control) -> None:
        """Adds a force u on a marker along its z axis, which turns with its body.

        `force` is the control u, N.
        """
        self._ready("thrust", name, {"marker": marker, "force": force})

    def torque_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, torque: Control) -> None:
        """Adds a torque u on the body of b about the z axis of b, and the opposite one on that of a.

        `torque` is the control u, N m.
        """
        self._ready("torque in space", name, {"a": a, "b": b, "torque": torque})

    def applied_in_space(self, name: str, marker: Marker | SpaceBody | Ground, force: Vector, torque: Vector) -> None:
        """Adds a constant force at a marker and a constant torque on its body.

        `force`, N, and `torque`, N m, have components in the inertial frame.
        """
        self._ready("applied in space", name, {"marker": marker, "force": force, "torque": torque})

    def applied_on_body(self, name: str, marker: Marker | SpaceBody | Ground, force: Vector, torque: Vector) -> None:
        """Adds a force at a marker and a torque on its body that turn with the body.

        `force`, N, and `torque`, N m, have constant components along the axes of the marker.
        """
        self._ready("applied on body", name, {"marker": marker, "force": force, "torque": torque})

    def two_point_actuator_in_space(self, name: str, a: Marker | SpaceBody | Ground, b: Marker | SpaceBody | Ground, force: Control) -> None:
        """Adds a force u that drives two markers apart.

        `force` is the control u, N. The points must not coincide.
        """
        self._ready("two-point actuator in space", name, {"a": a, "b": b, "force": force})

    def spring_damper_in_space(
        self,
        name: str,
        a: Marker | SpaceBody | Ground,
        b: Marker | SpaceBody | Ground,
        stiffness: Number,
        free_length: Number,
        damping: Number,
    ) -> None:
        """Adds a spring and a damper along the line between two markers with the distance l: the force k (l − l₀) + d dl/dt pulls them together.

        `stiffness` k, N/m; `free_length` l₀, m; `damping` d, N s/m. The points must not coincide, unless free length and damping are 0.
        """
        self._ready("spring and damper in space", name, {"a": a, "b": b, "stiffness": stiffness, "free_length": free_length, "damping": damping})

    def outputs_of_a_marker(
        self,
        name: str,
        marker: Marker | SpaceBody | Ground,
        quantity: str,
        sum: str | dict[str, int],
    ) -> tuple[Output, Output, Output]:
        """Adds three outputs: the x, y and z components of a quantity of a marker in the inertial frame.

        `quantity` is 'position' (m), 'velocity', 'acceleration', 'x axis', 'y axis', 'z axis', 'angular velocity' or 'angular acceleration'; `sum` is
        a sum over the nodes, as of a cost. Optimisers keep each output at zero unless `constraints` say otherwise.
        """
        return self._ready("outputs of a marker", name, {"marker": marker, "quantity": quantity, "sum": sum})

    def rotation_error(
        self,
        name: str,
        a: Marker | SpaceBody | Ground,
        b: Marker | SpaceBody | Ground,
        sum: str | dict[str, int],
    ) -> tuple[Output, Output, Output]:
        """Adds three outputs: the rotation from marker a to marker b, sin θ times the axis of a rotation by θ, in the inertial frame.

        `sum` is a sum over the nodes, as of a cost.
        """
        return self._ready("rotation error", name, {"a": a, "b": b, "sum": sum})

    def motor(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], force: Control) -> None:
        """Adds a force or torque u along an axis; in a joint it acts on b, and its reaction on a.

        `axis` is a coordinate s, or coordinates with factors, {q1: 1, q2: -2} for s = q1 − 2 q2. `force` is the control u, N or N m.
        """
        self._ready("motor", name, {"axis": axis, "force": force})

    def axis_force(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], motion: Motion1D) -> None:
        """Adds a prescribed force or torque along an axis.

        `axis` is a coordinate s, or coordinates with factors, {q1: 1, q2: -2} for s = q1 − 2 q2. `motion` is constant(…), constant_speed(…) or
        harmonic(…), N or N m.
        """
        self._ready("axis force", name, {"axis": axis, "motion": motion})

    def axis_spring_damper(
        self,
        name: str,
        axis: Coordinate | Mapping[Coordinate, Number],
        stiffness: Number,
        free_value: Number,
        damping: Number,
    ) -> None:
        """Adds a spring and a damper along an axis: the force −k (s − s₀) − d ds/dt.

        `axis` is a coordinate s, or coordinates with factors, {q1: 1, q2: -2} for s = q1 − 2 q2. `stiffness` k, N/m or N m/rad; `free_value` s₀, m or
        rad; `damping` d, N s/m or N m s/rad.
        """
        self._ready("axis spring and damper", name, {"axis": axis, "stiffness": stiffness, "free_value": free_value, "damping": damping})

    def axis_coulomb_friction(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], force: Number, speed: Number) -> None:
        """Adds dry friction along an axis, regularised: the force −F tanh((ds/dt)/v_s).

        `axis` is a coordinate s, or coordinates with factors, {q1: 1, q2: -2} for s = q1 − 2 q2. `force` F, N or N m; `speed` v_s, m/s or rad/s, near
        which the friction changes its sign. There is no sticking.
        """
        self._ready("axis Coulomb friction", name, {"axis": axis, "force": force, "speed": speed})

    def axis_end_stop(
        self,
        name: str,
        axis: Coordinate | Mapping[Coordinate, Number],
        lower: Number,
        upper: Number,
        stiffness: Number,
        damping: Number,
        width: Number,
    ) -> None:
        """Adds stops of a coordinate or of a sum of coordinates.

        Beyond a limit by δ > 0, the force k δ max(1 + c dδ/dt, 0) acts toward the range. `axis` is a coordinate s, or coordinates with factors, {q1:
        1, q2: -2} for s = q1 − 2 q2. `lower` and `upper`, m or rad; `stiffness` k, N/m or N m/rad; `damping` c, s/m or s/rad. `width`, m or rad, is
        the depth over which it begins smoothly; with the number 0 the part is an event, too: scene.find(name, 'event').
        """
        self._ready("axis end stop", name, {"axis": axis, "lower": lower, "upper": upper, "stiffness": stiffness, "damping": damping, "width": width})

    def rotor(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], inertia: Number, ratio: Number) -> None:
        """Adds the inertia of a rotor that turns n times as fast as the coordinate: T = ½ I (n ds/dt)².

        `axis` is a coordinate s, or coordinates with factors, {q1: 1, q2: -2} for s = q1 − 2 q2. `inertia` I, kg m² (or kg); `ratio` n.
        """
        self._ready("rotor", name, {"axis": axis, "inertia": inertia, "ratio": ratio})

    def driven_axis(self, name: str, axis: Coordinate | Mapping[Coordinate, Number], motion: Motion1D) -> Joint:
        """Adds a prescribed value of a coordinate or of a sum of coordinates.

        `axis` is a coordinate s, or coordinates with factors, {q1: 1, q2: -2} for s = q1 − 2 q2. `motion` is constant(…), constant_speed(…) or
        harmonic(…), m or rad. One equation.
        """
        return self._ready("driven axis", name, {"axis": axis, "motion": motion})

    def linear_relation(self, name: str, terms: Coordinate | Mapping[Coordinate, Number], c: Number) -> Joint:
        """Adds the relation Σ a_k q_k = c of coordinates, as of a gear between joints.

        `terms` are the coordinates with their factors, {q1: 1, q2: -2}; `c`, m or rad. One equation.
        """
        return self._ready("linear relation", name, {"terms": terms, "c": c})

    def open_at_event(self, event: Event, equations: Iterable[Equation]) -> None:
        """Lets an event open equations: they do not hold from then on, and no force of theirs acts."""
        self._ready("open at event", event, {"equations": equations})

    def close_at_event(self, event: Event, equations: Iterable[Equation]) -> None:
        """Lets an event close equations: they hold from then on, after a plastic impact. Before, they are open.

        A step of length zero must follow the node of the event.
        """
        self._ready("close at event", event, {"equations": equations})

    def hold_at_event(self, event: Event, equations: Iterable[Equation]) -> None:
        """Lets an event close equations at their present values, as of a foot that stays where it has landed.

        A step of length zero must follow the node of the event.
        """
        self._ready("hold at event", event, {"equations": equations})

    def impact_at_event(self, event: Event, restitution: Number, equation: Equation) -> None:
        """Makes an event an impact on an equation, whose rate is reversed, times the coefficient of restitution. The equation is open before and after.

        `restitution`, from 0 (plastic) to 1 (elastic). Two steps of length zero must follow the node of the event.
        """
        self._ready("impact at event", event, {"restitution": restitution, "equation": equation})

    def reaction_event(self, name: str, equation: Equation) -> Event:
        """Adds an event: the reaction of an equation becomes zero from below, that is, a contact that pushes would begin to pull."""
        return self._ready("reaction event", name, {"equation": equation})

    def event_time(self, name: str, event: int) -> Output:
        """Adds an output: the time of an event, s.

        `event` is its number in the events of the inputs, counted from 0.
        """
        return self._ready("event time", name, {"event": event})

    def event_impulse(self, name: str, equation: Equation, event: int) -> Output:
        """Adds an output: the impulse of an equation at an event, N s or N m s.

        `event` is its number in the events of the inputs, counted from 0.
        """
        return self._ready("event impulse", name, {"equation": equation, "event": event})
