"""Descriptions of the ready-made parts: by kind, a sentence, and the meanings of the arguments with their units."""

_POINTS = "The points must not coincide."
_LAW = "`stiffness` k, N/m^(3/2); `damping` c, s/m; `friction` is the coefficient μ, and `speed` v_s, m/s, smooths the friction near rest (there is no sticking)."
_WIDTH = (
    "The force begins smoothly over the `width`, m, which ten or more steps should cross. If it is the number 0, the force begins with a kink, and the part is "
    "an event, too: scene.find(name, 'event')."
)
_STOP = "Beyond a limit by δ > 0, {} k δ max(1 + c dδ/dt, 0) acts {}."
_SMOOTH = "`width`, {}, is the depth over which it begins smoothly; with the number 0 the part is an event, too: scene.find(name, 'event')."
_MOTION = "`motion` is constant(…), constant_speed(…) or harmonic(…), {}."
_AXIS = "`axis` is a coordinate s, or coordinates with factors, {q1: 1, q2: -2} for s = q1 − 2 q2."
_ANGLE = "`axis` is the angle of the direction in the frame of a, rad."
_ZERO = "{} of length zero must follow the node of the event."
_DRAWN = "It has no effect on the motion."
_COORDINATES = {
    "angle": "Its coordinate is the attribute `angle`, rad.",
    "offset": "Its coordinate is the attribute `offset`, m.",
}

TEXTS = {
    # Joints in the plane
    "revolute": ("A hinge: the points a and b coincide.", "Two equations."),
    "prismatic": (
        "A slider: the point b moves along a line through the point a and does not turn relative to a.",
        "`axis` is the angle of the line in the frame of a, rad; `angle` is φ_b − φ_a, rad. Two equations.",
    ),
    "weld": ("A rigid connection of two points.", "`angle` is φ_b − φ_a, rad. Three equations."),
    "distance": ("A rod without mass: two points keep a distance.", "`length`, m. One equation; the points must not coincide."),
    "driven angle": ("A prescribed angle φ_b − φ_a.", _MOTION.format("rad") + " One equation."),
    "driven distance": ("A prescribed distance between two points, as of a cylinder.", _MOTION.format("m, and positive") + " One equation."),
    "driven slider": ("A prescribed position of the point b along an axis of a.", f"{_ANGLE} {_MOTION.format('m')} One equation."),
    "gear": (
        "Two wheels that roll on each other, from their initial angles, in opposite directions.",
        "`radius_a` and `radius_b`, m; a negative one is that of a ring gear around the other wheel. The axles must be fixed by revolute joints. One equation.",
    ),
    "rack": ("A rack along which a wheel rolls, from their initial positions.", "`axis` is the direction of the rack in the inertial frame, rad; `radius` is that of the pinion, m. One equation."),
    "rigid contact": (
        "The gap between the point b and a line through the point a, as an equation and as an event of this name (scene.find(name, 'event')).",
        "`normal` is the direction of the outer normal in the frame of a, rad. What the event does is added by impact_at_event, close_at_event or open_at_event; "
        "otherwise the equation always holds.",
    ),
    # Forces in the plane
    "two-point actuator": ("A force u along the line between two points, which pushes them apart if it is positive.", f"`force` is the control u, N. {_POINTS}"),
    "applied force": ("A prescribed force at a point of a body.", f"`direction` is an angle in the inertial frame, rad. {_MOTION.format('N')}"),
    "applied torque": ("A prescribed torque on a body.", _MOTION.format("N m")),
    "spring and damper": (
        "A spring and a damper along the line between two points with the distance l: the force k (l − l₀) + d dl/dt pulls them together.",
        f"`stiffness` k, N/m; `free_length` l₀, m; `damping` d, N s/m. {_POINTS[:-1]}, unless free length and damping are 0.",
    ),
    "torsional spring and damper": (
        "A spring and a damper of the relative angle φ = φ_b − φ_a: the torque −k (φ − φ₀) − d dφ/dt acts on b, and its reaction on a.",
        "`stiffness` k, N m/rad; `free_angle` φ₀, rad; `damping` d, N m s/rad.",
    ),
    "joint friction": ("Viscous friction against the relative rotation ω = dφ_b/dt − dφ_a/dt: the torque −d ω on b, and its reaction on a.", "`damping` d, N m s/rad."),
    "sliding friction": ("Viscous friction of the point b along an axis of a: the force −d ds/dt on b, and its reaction on a.", f"{_ANGLE} `damping` d, N s/m."),
    "actuator": ("A force u on the point b along an axis of a, and its reaction on a.", f"{_ANGLE} `force` is the control u, N."),
    "torque actuator": ("A torque u on b, and its reaction on a.", "`torque` is the control u, N m."),
    "bushing": (
        "An elastic connection of two points: springs and dampers along x and y of the frame of a, and against the relative rotation.",
        "`stiffness_x` and `stiffness_y`, N/m; `stiffness_angle`, N m/rad; `damping_x` and `damping_y`, N s/m; `damping_angle`, N m s/rad.",
    ),
    "Coulomb friction": (
        "Dry friction in a hinge, regularised: the torque −M tanh(ω/ω_s) on b with ω = dφ_b/dt − dφ_a/dt, and its reaction on a.",
        "`torque` M, N m; `speed` ω_s, rad/s, near which the friction changes its sign. There is no sticking; a small speed is stiff and needs an L-stable scheme.",
    ),
    "Coulomb sliding friction": (
        "Dry friction of the point b along an axis of a, regularised: the force −F tanh((ds/dt)/v_s) on b, and its reaction on a.",
        f"{_ANGLE} `force` F, N; `speed` v_s, m/s, near which the friction changes its sign. There is no sticking.",
    ),
    "contact": (
        "The contact of the point b with a half-plane through the point a: at the depth δ > 0, the normal force N = k δ^(3/2) max(1 + c dδ/dt, 0) and the friction "
        "−μ N tanh(v/v_s).",
        f"`normal` is the direction of the outer normal in the frame of a, rad; {_LAW} Returns the event that the gap is zero. Steps must resolve the contact.",
    ),
    "circle contact": (
        "The contact of a circle about the point b with a half-plane through the point a: at the depth δ > 0, the normal force N = k δ^(3/2) max(1 + c dδ/dt, 0) and "
        "the friction −μ N tanh(v/v_s).",
        f"`normal` is the direction of the outer normal in the frame of a, rad; `radius`, m; {_LAW} {_WIDTH}",
    ),
    "contact of circles": (
        "The contact of circles about the points a and b: at the depth δ > 0, the normal force N = k δ^(3/2) max(1 + c dδ/dt, 0) and the friction −μ N tanh(v/v_s).",
        f"`radius_a` and `radius_b`, m; a negative `radius_a` is that of a bore around the circle of b. {_LAW} {_WIDTH}",
    ),
    "end stop": (
        "Stops of the relative angle φ_b − φ_a.",
        _STOP.format("the torque", "on b toward the range, and its reaction on a")
        + " `lower` and `upper`, rad; `stiffness` k, N m/rad; `damping` c, s/rad. "
        + _SMOOTH.format("rad"),
    ),
    "sliding end stop": (
        "Stops of the position of the point b along an axis of a, which is 0 at the point a.",
        f"{_STOP.format('the force', 'on b toward the range, and its reaction on a')} {_ANGLE} `lower` and `upper`, m; `stiffness` k, N/m; `damping` c, s/m. "
        + _SMOOTH.format("m"),
    ),
    "drawn spring": ("Draws a spring between two points in pictures.", _DRAWN),
    "drawn rod": ("Draws a rod between two points in pictures.", _DRAWN),
    # Bodies and joints in space
    "body in space": (
        "A rigid body in space, which a joint must carry.",
        "`mass`, kg; `inertia` J_xx, J_yy, J_zz, J_xy, J_xz, J_yz about the centre of mass along the axes of the body, kg m², with J_xy = −∫ x y dm; `centre` is "
        "the centre of mass in the frame of the body, m, by default its origin; `lengths` are the edges of a cuboid, m, that must not be negative; `unchecked` accepts moments "
        "of inertia that no body can have.",
    ),
    "planar body": ("A body in the plane as a body in space, for joints that carry bodies in space and for markers.", ""),
    "revolute in space": ("A hinge: b turns relative to a about their common z axis.", _COORDINATES["angle"]),
    "prismatic in space": ("A slider: b moves relative to a along their common z axis.", _COORDINATES["offset"]),
    "dependent revolute": ("A hinge whose angle is factor · q + offset, as of a gear.", "`of` is the coordinate q of another joint; `factor` and `offset`, rad."),
    "dependent prismatic": ("A slider whose displacement is factor · q + offset, as of a rack.", "`of` is the coordinate q of another joint; `factor` and `offset`, m."),
    "universal": (
        "A universal joint: b turns relative to a about the x axis of a, then about its own y axis.",
        "Its coordinates are scene['name.first angle'] and scene['name.second angle'], rad.",
    ),
    "cylindrical": ("A cylindrical joint: b moves along and turns about the common z axis.", "Its coordinates are the attributes `offset`, m, and `angle`, rad."),
    "planar joint": ("A planar joint: b moves in the x–y plane of a and turns about its z axis.", "Its coordinates are the attributes `x` and `y`, m, and `angle`, rad."),
    "fixed": ("A joint that fixes b to a, so that both move as one.", ""),
    "load cell": (
        "A joint that fixes b to a and measures: the reactions of its six equations are the force and the torque that it transmits.",
        "Read them as cell[0].lam … cell[5].lam in costs and outputs.",
    ),
    "ball": ("A ball joint.", "Its coordinates are the Euler parameters e0, e1, e2, e3, the scalar first, with one equation |e| = 1."),
    "free": ("A joint that lets b move freely relative to a.", "Its coordinates are x, y, z, m, and the Euler parameters e0, e1, e2, e3, the scalar first."),
    "cut": (
        "A cut of a long chain of joints at a body, which makes steps faster and does not change the motion.",
        "Cut chains of more than about 50 joints at every sixth body. Parts that are attached later belong to the second half.",
    ),
    # Loops in space
    "close ball": ("A loop that is closed by a ball joint.", "Three equations: the markers coincide. Their reactions are forces along the axes of a, N."),
    "close parallel": ("A constraint by which the z axes of two markers are parallel.", "Two equations, x_a·z_b = y_a·z_b = 0."),
    "close revolute": ("A loop that is closed by a hinge about the common z axis.", "Five equations: those of close_ball and close_parallel."),
    "close cylindrical": ("A loop that is closed by a slider along and about the common z axis.", "Four equations: those of point_on_line and close_parallel."),
    "close prismatic": ("A loop that is closed by a slider along the common z axis.", "Five equations: those of close_cylindrical, and x_a·y_b = 0."),
    "close fixed": ("A loop that is closed by a weld.", "Six equations: those of close_revolute, and x_a·y_b = 0."),
    "point on plane": ("A constraint by which b stays in the x–y plane of a.", "One equation."),
    "point on line": ("A constraint by which b stays on the z axis of a.", "Two equations."),
    "distance in space": ("A rod without mass: two markers keep a distance.", "`length`, m. One equation, whose reaction is the tension of the rod, N."),
    "driven distance in space": ("A prescribed distance of two markers, as of a ram.", _MOTION.format("m, and positive") + " One equation."),
    # Forces in space
    "thrust": ("A force u on a marker along its z axis, which turns with its body.", "`force` is the control u, N."),
    "torque in space": ("A torque u on the body of b about the z axis of b, and the opposite one on that of a.", "`torque` is the control u, N m."),
    "applied in space": ("A constant force at a marker and a constant torque on its body.", "`force`, N, and `torque`, N m, have components in the inertial frame."),
    "applied on body": (
        "A force at a marker and a torque on its body that turn with the body.",
        "`force`, N, and `torque`, N m, have constant components along the axes of the marker.",
    ),
    "two-point actuator in space": ("A force u that drives two markers apart.", f"`force` is the control u, N. {_POINTS}"),
    "spring and damper in space": (
        "A spring and a damper along the line between two markers with the distance l: the force k (l − l₀) + d dl/dt pulls them together.",
        f"`stiffness` k, N/m; `free_length` l₀, m; `damping` d, N s/m. {_POINTS[:-1]}, unless free length and damping are 0.",
    ),
    "outputs of a marker": (
        "Three outputs: the x, y and z components of a quantity of a marker in the inertial frame.",
        "`quantity` is 'position' (m), 'velocity', 'acceleration', 'x axis', 'y axis', 'z axis', 'angular velocity' or 'angular acceleration'; `sum` is a sum over "
        "the nodes, as of a cost. Optimisers keep each output at zero unless `constraints` say otherwise.",
    ),
    "rotation error": (
        "Three outputs: the rotation from marker a to marker b, sin θ times the axis of a rotation by θ, in the inertial frame.",
        "`sum` is a sum over the nodes, as of a cost.",
    ),
    # Parts along coordinates
    "motor": ("A force or torque u along an axis; in a joint it acts on b, and its reaction on a.", f"{_AXIS} `force` is the control u, N or N m."),
    "axis force": ("A prescribed force or torque along an axis.", f"{_AXIS} {_MOTION.format('N or N m')}"),
    "axis spring and damper": (
        "A spring and a damper along an axis: the force −k (s − s₀) − d ds/dt.",
        f"{_AXIS} `stiffness` k, N/m or N m/rad; `free_value` s₀, m or rad; `damping` d, N s/m or N m s/rad.",
    ),
    "axis Coulomb friction": (
        "Dry friction along an axis, regularised: the force −F tanh((ds/dt)/v_s).",
        f"{_AXIS} `force` F, N or N m; `speed` v_s, m/s or rad/s, near which the friction changes its sign. There is no sticking.",
    ),
    "axis end stop": (
        "Stops of a coordinate or of a sum of coordinates.",
        f"{_STOP.format('the force', 'toward the range')} {_AXIS} `lower` and `upper`, m or rad; `stiffness` k, N/m or N m/rad; `damping` c, s/m or s/rad. "
        + _SMOOTH.format("m or rad"),
    ),
    "rotor": (
        "The inertia of a rotor that turns n times as fast as the coordinate: T = ½ I (n ds/dt)².",
        f"{_AXIS} `inertia` I, kg m² (or kg); `ratio` n.",
    ),
    "driven axis": ("A prescribed value of a coordinate or of a sum of coordinates.", f"{_AXIS} {_MOTION.format('m or rad')} One equation."),
    "linear relation": ("The relation Σ a_k q_k = c of coordinates, as of a gear between joints.", "`terms` are the coordinates with their factors, {q1: 1, q2: -2}; `c`, m or rad. One equation."),
    # Events
    "open at event": ("Lets an event open equations: they do not hold from then on, and no force of theirs acts.", ""),
    "close at event": ("Lets an event close equations: they hold from then on, after a plastic impact. Before, they are open.", _ZERO.format("A step")),
    "hold at event": ("Lets an event close equations at their present values, as of a foot that stays where it has landed.", _ZERO.format("A step")),
    "impact at event": (
        "Makes an event an impact on an equation, whose rate is reversed, times the coefficient of restitution. The equation is open before and after.",
        "`restitution`, from 0 (plastic) to 1 (elastic). " + _ZERO.format("Two steps"),
    ),
    "reaction event": ("An event: the reaction of an equation becomes zero from below, that is, a contact that pushes would begin to pull.", ""),
    "event time": ("An output: the time of an event, s.", "`event` is its number in the events of the inputs, counted from 0."),
    "event impulse": ("An output: the impulse of an equation at an event, N s or N m s.", "`event` is its number in the events of the inputs, counted from 0."),
}

# Kinds whose methods return a Joint: joints and constraints. Other parts return nothing, or what `parts.py` lists.
JOINTS = set(
    "revolute, prismatic, weld, distance, driven angle, driven distance, driven slider, gear, rack, rigid contact, revolute in space, prismatic in space, "
    "dependent revolute, dependent prismatic, universal, cylindrical, planar joint, fixed, load cell, ball, free, close ball, close parallel, "
    "close revolute, close cylindrical, close prismatic, close fixed, point on plane, point on line, distance in space, driven distance in space, "
    "driven axis, linear relation".split(", ")
)
