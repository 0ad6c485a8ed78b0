//! Bodies in space that are described wrongly, and descriptions at the edge of what is right.

use hamiltonian_adjoint::planar::ConstantSpeed;
use hamiltonian_adjoint::spatial::{Body, Inertia, Spatial};
use hamiltonian_adjoint::{Error, Grid, Inputs, Mechanics, Param, Scene, Settings, Solver};

use crate::common::assert_says;

/// The error of a scene with a body on a hinge and what is added to it.
fn refused(add: impl FnOnce(&mut Spatial, Body)) -> Error {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    let rod = space.body("rod", Inertia::cuboid(1.0, [0.1, 0.1, 1.0]));
    space.revolute("hinge", Body::GROUND.origin().along([0.0, 1.0, 0.0]), rod.at([0.0, 0.0, 0.5]).along([0.0, 1.0, 0.0]));
    add(&mut space, rod);
    scene.compile().map(|_| ()).expect_err("a wrong scene")
}

fn more(space: &mut Spatial) -> Body {
    space.body("more", Inertia::cuboid(1.0, [0.1, 0.1, 1.0]))
}

/// Asserts that a body with this inertia is refused by its name.
fn assert_odd(inertia: Inertia) {
    let error = refused(|space, rod| {
        let body = space.body("odd", inertia);
        space.fixed("weld", rod.origin(), body.origin());
    });
    assert_says(&error, &["`odd`"]);
}

#[test]
fn axes_without_a_direction_are_refused() {
    for bad in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 1.0], [1e-200, 0.0, 0.0], [0.0, -1e200, 0.0]] {
        let error = refused(|space, rod| {
            let more = more(space);
            space.revolute("wrist", rod.origin().along(bad), more.origin());
        });
        assert_says(&error, &["`wrist`"]);
    }
    for parallel in [[0.0, 0.0, 3.0], [0.0, 0.0, -1.0], [0.0; 3], [0.0, f64::NAN, 0.0]] {
        let error = refused(|space, rod| {
            let more = more(space);
            space.prismatic("slide", rod.origin().along_and_toward([0.0, 0.0, 1.0], parallel), more.origin());
        });
        assert_says(&error, &["`slide`"]);
    }
    // Parallel but for rounding.
    let error = refused(|space, rod| {
        let more = more(space);
        space.prismatic(
            "slide",
            rod.origin().along_and_toward([0.1, 0.2, 0.3], [0.1 * 3.0, 0.2 * 3.0, 0.3 * 3.0]),
            more.origin(),
        );
    });
    assert_says(&error, &["`slide`", "parallel"]);
}

#[test]
fn numbers_that_are_negative_or_not_finite_are_refused() {
    let nan = f64::NAN;
    let inertias = [
        Inertia::sphere(nan, 1.0),
        Inertia::sphere(1.0, nan),
        Inertia::point(1.0).centred_at([0.0, nan, 0.0]),
        Inertia::point(-1.0),
        Inertia::point(f64::INFINITY),
        Inertia::sphere(1.0, -0.1),
        Inertia::cuboid(0.0, [0.1, -0.1, 0.1]),
    ];
    for inertia in inertias {
        assert_odd(inertia);
    }
    let mut scene = Scene::new();
    let radius = scene.design("radius", 0.1);
    let ball = scene.spatial().body("ball", Inertia::sphere(1.0, radius - 0.2));
    scene.spatial().ball("socket", Body::GROUND.origin(), ball.origin());
    let error = scene.compile().map(|_| ()).expect_err("a negative radius");
    assert_says(&error, &["radius of `ball`", "-0.1", "not negative"]);
    let error = refused(|space, rod| {
        let more = more(space);
        space.ball("socket", rod.at([nan, 0.0, 0.0]), more.origin());
    });
    assert_says(&error, &["`socket`"]);
    let error = refused(|space, rod| {
        let more = more(space);
        space.ball("socket", rod.origin().turned([0.0, f64::INFINITY, 0.0]), more.origin());
    });
    assert_says(&error, &["`socket`"]);
    assert_says(&refused(|space, _| space.gravity([0.0, 0.0, nan])), &["gravity"]);
    let error = refused(|space, rod| space.spring_damper("spring", Body::GROUND.origin(), rod.origin(), [1.0, nan, 0.0]));
    assert_says(&error, &["`spring"]);
    for length in [0.0, -1.0, nan] {
        let error = refused(|space, rod| {
            space.distance("rope", Body::GROUND.origin(), rod.origin(), length);
        });
        assert_says(&error, &["`rope`"]);
    }
    let error = refused(|space, rod| {
        space.driven_distance("ram", Body::GROUND.origin(), rod.origin(), ConstantSpeed, [1.0.into(), nan.into()]);
    });
    assert_says(&error, &["`ram`"]);
}

#[test]
fn parts_of_other_scenes_are_refused() {
    let mut other = Scene::new();
    let design = other.design("length", 1.0);
    let control = other.control("torque");
    let mut space = other.spatial();
    for _ in 0..5 {
        space.body("other", Inertia::point(1.0));
    }
    let foreign = space.body("foreign", Inertia::point(1.0));
    let hinge = space.revolute("hinge", Body::GROUND.origin(), foreign.origin());
    let error = refused(|space, rod| {
        space.revolute("wrist", rod.origin(), foreign.origin());
    });
    assert_says(&error, &["`wrist`"]);
    let error = refused(|space, rod| {
        space.close_ball("end", foreign.origin(), rod.origin());
    });
    assert_says(&error, &["`end`"]);
    let error = refused(|space, rod| space.torque("motor", Body::GROUND.origin(), rod.origin(), control));
    assert_says(&error, &["`motor`"]);
    let error = refused(|space, rod| {
        let more = more(space);
        space.dependent_revolute("gear", rod.origin(), more.origin(), hinge.angle, [2.0, 0.0]);
    });
    assert_says(&error, &["`gear`"]);
    for inertia in [Inertia::point(design), Inertia::point(1.0).centred_at((0.0, 0.0, design))] {
        assert_odd(inertia);
    }
    let error = refused(|space, rod| {
        let more = more(space);
        space.ball("socket", rod.at((0.0, 0.0, Param::from(design) * 2.0)), more.origin());
    });
    assert_says(&error, &["`socket`"]);
}

#[test]
fn joints_that_make_no_tree_are_refused() {
    let error = refused(|space, rod| {
        space.ball("second", Body::GROUND.origin(), rod.origin());
    });
    assert_says(&error, &["`second`", "`hinge`", "`rod`"]);
    let error = refused(|space, rod| {
        space.ball("itself", rod.origin(), rod.origin());
    });
    assert_says(&error, &["`itself`", "one body to itself"]);
    let error = refused(|space, _| {
        more(space);
    });
    assert_says(&error, &["`more`"]);
    let error = refused(|space, rod| {
        let more = more(space);
        space.close_ball("early", rod.origin(), more.origin());
        space.ball("socket", rod.origin(), more.origin());
    });
    assert_says(&error, &["`early`", "`more`"]);
    let error = refused(|space, _| {
        let more = more(space);
        space.ball("loose", more.origin(), more.origin());
    });
    assert_says(&error, &["`loose`", "one body to itself"]);
    for body in [|_: &mut Spatial, rod| rod, |space: &mut Spatial, _| more(space)] {
        let error = refused(|space, rod| {
            let carried = body(space, rod);
            space.free("ground", carried.origin(), Body::GROUND.origin());
        });
        assert_says(&error, &["`ground`", "exchange both markers"]);
    }
    let error = refused(|space, _| {
        space.close_fixed("still", Body::GROUND.origin(), Body::GROUND.origin());
    });
    assert_says(&error, &["`still`"]);
    let error = refused(|space, rod| {
        space.distance("rope", rod.origin(), rod.at([1.0, 0.0, 0.0]), 1.0);
    });
    assert_says(&error, &["`rope`"]);
}

#[test]
fn a_leaf_without_mass_is_named() -> Result<(), Error> {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    let rod = space.body("rod", Inertia::cuboid(1.0, [0.1, 0.1, 1.0]));
    space.ball("socket", Body::GROUND.origin(), rod.at([0.0, 0.0, 0.5]));
    let leaf = space.body("leaf", Inertia::none());
    space.revolute("wrist", rod.origin(), leaf.origin());
    let point = space.body("point", Inertia::point(1.0));
    space.revolute("spindle", rod.at([0.0, 0.0, -0.5]), point.origin());
    let system = scene.compile()?;
    let error = Solver::new(&system, Settings::default())
        .simulate(&Inputs::at_rest(&system, Grid::uniform(3, 0.01)))
        .map(|_| ())
        .expect_err("a singular mass matrix");
    assert_says(&error, &["`wrist.angle`", "`spindle.angle`"]);
    Ok(())
}

#[test]
fn euler_parameters_that_are_not_normalised_are_refused() -> Result<(), Error> {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    let rod = space.body("rod", Inertia::cuboid(1.0, [0.1, 0.1, 1.0]));
    let joint = space.ball("socket", Body::GROUND.origin(), rod.at([0.0, 0.0, 0.5]));
    let system = scene.compile()?;
    for (values, words) in
        [([1.0, 0.1, 0.0, 0.0], "5.000e-3"), ([0.0; 4], "5.000e-1"), ([1.0 + 1e-7, 0.0, 0.0, 0.0], "1.000e-7")]
    {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.01));
        joint.orientation.iter().zip(values).for_each(|(q, value)| inputs.start.set_coordinate(*q, value));
        let error = Solver::new(&system, Settings::default()).simulate(&inputs).map(|_| ()).expect_err("another length");
        assert_says(&error, &["`socket (|e| = 1)`", words]);
    }
    Ok(())
}

/// The mass matrix of a hinge with these axes on both sides, then one of a tilted hinge.
fn mass(first: [f64; 3], second: [f64; 3]) -> Result<Vec<f64>, Error> {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity([1.0, 2.0, 3.0]);
    let [inner, outer] = ["inner", "outer"].map(|name| space.body(name, Inertia::cuboid(1.0, [0.1, 0.2, 1.0])));
    space.revolute("a", Body::GROUND.origin().along(first), inner.at([0.1, 0.2, 0.3]).along(second));
    space.revolute("b", inner.at([0.3, 0.0, 0.5]).along(second), outer.at([0.0, 0.2, 0.4]).along(first));
    let system = scene.compile()?;
    let at = Mechanics::new(&system, &[0.3, -0.4], &[1.0, 2.0])?;
    Ok([at.mass().as_slice(), at.accelerations()?.0.as_slice()].concat())
}

#[test]
fn axes_of_any_length_and_with_rounding_mean_the_same() -> Result<(), Error> {
    let compare = |axes: [[f64; 3]; 2], others: [[f64; 3]; 2]| -> Result<(), Error> {
        let (own, other) = (mass(axes[0], axes[1])?, mass(others[0], others[1])?);
        let error = crate::common::relative_error(&own, &other);
        println!("{axes:?}: {error:.1e}");
        assert!(error < 1e-12, "{axes:?}: {own:?} for {other:?}");
        Ok(())
    };
    for axis in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.8, 0.0]] {
        for rounding in [-1e-17, 1e-17] {
            compare([axis, [axis[0], axis[1], rounding]], [axis; 2])?;
        }
    }
    let axis = [0.3, -0.5, -0.2];
    for length in [1e-100, 1e-30, 1e30, 1e100] {
        compare([axis.map(|x| x * length), axis], [axis; 2])?;
    }
    Ok(())
}

/// Φ depends on the place of the first body by rounding only.
#[test]
fn a_plane_that_moves_in_itself_can_hold_a_body() -> Result<(), Error> {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let inertia = Inertia::new(1.0, [0.3, 0.25, 0.2, 0.01, 0.02, 0.03]).centred_at([0.1, 0.2, 0.3]);
    let [table, top] = ["table", "top"].map(|name| space.body(name, inertia));
    space.planar("floor", Body::GROUND.at([0.1, 0.2, 0.3]).along([1.0, 2.0, 3.0]), table.at([0.3, 0.0, 0.1]));
    space.ball("socket", Body::GROUND.origin(), top.at([0.2, 0.1, 0.3]));
    space.point_on_plane("plane", table.at([0.1, 0.0, 0.3]), top.at([0.3, 0.2, 0.1]));
    let system = scene.compile()?;
    let q = [0.3, 0.2, -0.3, -0.6, 0.0, 0.8, 0.0];
    let (v_dot, _) = Mechanics::new(&system, &q, &[0.0; 7])?.accelerations()?;
    let along: f64 = (0..4).map(|i| q[3 + i] * v_dot[3 + i]).sum();
    assert!(v_dot.amax() > 1.0 && along.abs() < 1e-12, "{v_dot}");
    Ok(())
}
