use super::super::{Free, MultipleShooting, Problem, Quantity};
use super::*;
use crate::scenes::CartPendulum;
use crate::{Cost, CostPoint, Force, ForcePoint, Grid, KineticEnergy, Scalar, Scene, Scheme, Settings, Sum};
use nalgebra::SVector;

/// h = u² u̇ + u̇² (1 + q²).
struct Rough;

impl Cost<1, 0, 1> for Rough {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        let (u, rate) = (at.u[0], at.u_dot[0]);
        u * u * rate + rate * rate * (at.q[0] * at.q[0] + 1.0)
    }
}

/// h = u⁴ (2 + q).
struct Effort;

impl Cost<1, 0, 1> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.u[0].powi(4) * (at.q[0] + 2.0)
    }
}

/// All segments of a motion of a cart with two links.
fn segments(scheme: Scheme, quantity: fn(crate::Control) -> Quantity, sum: Sum, is_rough: bool) -> MultipleShooting {
    let mut cart = CartPendulum::with_links(2).mechanism();
    let place = cart.cart.coordinates[0];
    match is_rough {
        true => cart.scene.cost("rough", Rough, sum, [place], [], [cart.force], []),
        false => cart.scene.cost("effort", Effort, sum, [place], [], [cart.force], []),
    }
    let states: Vec<Coordinate> = std::iter::once(place).chain(cart.links.iter().map(|link| link.coordinates[2])).collect();
    let system = cart.scene.compile().expect("a system");
    let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, (0..12).map(|k| 0.02 + 0.001 * k as f64).collect()));
    inputs.controls.iter_mut().enumerate().for_each(|(k, u)| *u = 5.0 * (1.1 * k as f64).sin());
    let free = vec![Free::new(quantity(cart.force)).scaled(2.0), Free::duration().scaled(0.3)];
    let settings = Settings { scheme, ..Settings::default() };
    MultipleShooting::new(&system, settings, inputs, free, &states, 3).expect("a problem")
}

/// Compares the Hessian of each segment with products.
fn assert_consists_of_products(what: &str, problem: &mut MultipleShooting) {
    let x = problem.start();
    problem.evaluate(&x, &mut vec![0.0; problem.constraints().len()]).expect("a motion");
    for (k, segment) in problem.segments.iter_mut().enumerate() {
        let (size, n) = (segment.places.len(), segment.motion.solver.system().n());
        let ends: Vec<f64> = (0..3 * n).map(|i| (i as f64).cos()).collect();
        segment.gradient(1.0, (&[], &ends), &mut vec![0.0; size]).expect("a gradient");
        let hessian = segment.hessian().expect("a Hessian");
        let (mut direction, mut product) = (vec![0.0; size], vec![0.0; size]);
        for i in 0..size {
            direction[i] = 1.0;
            segment.product(&direction, &mut product).expect("a product");
            direction[i] = 0.0;
            let far = (0..size).fold(0.0f64, |most, j| most.max((product[j] - hessian[(j, i)]).abs()));
            assert!(far < 1e-11 * hessian.amax(), "{what}: segment {k}, variable {i}: {far:.1e} of {:.1e}", hessian.amax());
        }
    }
}

#[test]
fn the_hessian_consists_of_products() {
    let forms: [fn(crate::Control) -> Quantity; 3] =
        [Quantity::Control, |u| Quantity::LinearControl(u, 5), |u| Quantity::SplineControl(u, 7)];
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
        for (form, of) in forms.into_iter().enumerate() {
            for (sum, is_rough) in
                [(Sum::Trapezoidal, false), (Sum::Trapezoidal, true), (Sum::Plain, true), (Sum::AllNodes, true)]
            {
                let mut problem = segments(scheme, of, sum, is_rough);
                assert_consists_of_products(&format!("{} {form} {sum:?} {is_rough}", scheme.name), &mut problem);
            }
        }
    }
}

/// A mass that is driven by b v² + u: long steps have no solution and are halved. h = q v + v u t + u² + v̇² u.
struct Runaway;

impl KineticEnergy<1> for Runaway {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

impl Force<1, 1, 1> for Runaway {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([b[0] * at.v[0] * at.v[0] + at.u[0]])
    }
}

impl Cost<1, 0, 1> for Runaway {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.q[0] * at.v[0] + at.v[0] * at.u[0] * at.t + at.u[0] * at.u[0] + at.v_dot[0] * at.v_dot[0] * at.u[0]
    }
}

/// h = p* ṗ* u + p*².
struct Momenta;

impl Cost<1, 0, 1> for Momenta {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.p_star[0] * at.p_star_dot[0] * at.u[0] + at.p_star[0] * at.p_star[0]
    }
}

#[test]
fn the_hessian_of_halved_steps_consists_of_products() {
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
        for count in [1, 3] {
            let mut scene = Scene::new();
            let x = scene.coordinates("sled", ["x"]);
            let (u, b) = (scene.control("push"), scene.design("gain", 1.0));
            scene.kinetic_energy("mass", Runaway, x, []);
            scene.force("drive", Runaway, x, [u], [b.into()]);
            scene.cost("cost", Runaway, Sum::Trapezoidal, x, [], [u], []);
            if count == 1 {
                scene.cost("momenta", Momenta, Sum::Trapezoidal, x, [], [u], []);
            }
            let system = scene.compile().expect("a system");
            let steps = vec![0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.5, 0.15, 0.01];
            let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, steps));
            inputs.start.rate_mut()[0] = 1.0;
            inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 0.01 * (i as f64).sin());
            let free = [Quantity::Control(u), Quantity::Design(b), Quantity::Coordinate(x[0]), Quantity::Rate(x[0])];
            let free = free.into_iter().map(Free::new).collect();
            let settings = Settings { scheme, ..Settings::default() };
            let mut problem = MultipleShooting::new(&system, settings, inputs, free, &x, count).expect("a problem");
            assert_consists_of_products(&format!("{}, {count} segments", scheme.name), &mut problem);
            let last = &problem.segments[count - 1].motion.solver;
            let is_halved = !last.trajectory().inserted.is_empty();
            assert!(is_halved || count > 1 || scheme == Scheme::ESDIRK4, "no halved steps");
        }
    }
}
