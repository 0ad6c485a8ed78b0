//! A blow on one coordinate: p̄ = p*⁻ + b_p e_i with a parameter b_p. It shows what an event takes, and is tested like one.

use std::cell::RefCell;

use super::{Along, Backward, BackwardAlong, Forward, Lifted, OnNumbers, ResetMap};
use crate::Error;
use crate::linear::Breakdown;
use crate::motion::{Impulse, Report, Trajectory};
use crate::node::StepFailure;
use crate::number::Real;

thread_local! {
    static GIVEN: RefCell<Vec<(usize, Impulse)>> = const { RefCell::new(Vec::new()) };
}

/// The impulse of a test at a node.
pub(crate) fn impulse_at(node: usize) -> Option<Impulse> {
    GIVEN.with_borrow(|given| given.iter().find(|(at, _)| *at == node).map(|(_, impulse)| *impulse))
}

impl ResetMap for Impulse {
    fn forward(&self, of: Forward) -> Result<(), StepFailure> {
        of.after.p_star[self.coordinate] += of.motion.design[self.parameter];
        Ok(())
    }

    fn monitor(&self, _: usize, _: &mut Trajectory, _: &mut Report) {}

    fn backward(&self, of: &mut Backward) -> Result<(), Breakdown> {
        of.end.p_star.copy_from_slice(&of.after.p_star);
        of.end.sigma.copy_from_slice(&of.after.sigma);
        of.design[self.parameter] += of.after.p_star[self.coordinate];
        Ok(())
    }

    fn along(&self, of: Along) -> Result<(), Breakdown> {
        of.after.p_star[self.coordinate] += of.change.design[self.parameter];
        Ok(())
    }

    /// The reset map is linear, so that its derivatives do not change along a direction.
    fn backward_along(&self, mut of: BackwardAlong) -> Result<(), Breakdown> {
        self.backward(&mut of.of)
    }
}

impl<R: Real> OnNumbers<R> for Impulse {
    fn reset(&self, of: Lifted<R>) -> Result<(), Error> {
        of.after.p_star[self.coordinate] += of.end.design[self.parameter];
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::Input;
    use crate::number::Hyper;
    use crate::planar::Body;
    use crate::{
        Composition, Cost, CostPoint, Cx, Gradient, Grid, Inputs, LiftedSolver, LongSolver, Scalar, Scene, Scheme, Settings,
        Solver, Sum, System,
    };
    use nalgebra::SVector;

    /// (q₀ v₁ + q₁² + sin q₂ v₂) σ₀.
    struct Mixed;

    impl Cost<3, 1, 0, 0> for Mixed {
        fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 1, 0>, _b: &SVector<S, 0>) -> S {
            let CostPoint { q, v, sigma, .. } = at;
            (q[0] * v[1] + q[1] * q[1] + q[2].sin() * v[2]) * (sigma[0] + 1.0)
        }
    }

    /// A double pendulum, the mass of whose outer body is also the impulse; more than one foot make constraints depend on each other.
    fn pendulum(sum: Sum, feet: usize) -> System {
        let mut scene = Scene::new();
        let mass = scene.design("mass", 0.7);
        let inner = scene.body("inner", 1.3, 0.1, [0.5, 0.0, 0.0]);
        let outer = scene.body("outer", mass, 0.05, [1.5, 0.0, 0.0]);
        for k in 0..feet {
            scene.revolute(&format!("foot {k}"), Body::GROUND.at(0.0, 0.0), inner.at(-0.5, 0.0));
        }
        let elbow = scene.revolute("elbow", inner.at(0.5, 0.0), outer.at(-0.5, 0.0));
        scene.gravity(0.0, -9.81);
        let force = scene.control("force");
        scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.3, outer.at(0.2, 0.1), force);
        scene.cost("mixed", Mixed, sum, outer.coordinates, [elbow[0]], [], []);
        scene.compile().expect("a scene")
    }

    fn settings() -> [Settings; 4] {
        let restarted = Settings { rebase_every: 2, drift_bound: 0.0, ..Settings::default() };
        let [plain, stages] = [Settings::default(), Settings { scheme: Scheme::ESDIRK4, ..Settings::default() }];
        [plain, stages, restarted, Settings { scheme: Scheme::ESDIRK4, ..restarted }]
    }

    /// Blows on a coordinate of the outer body and on its angle.
    fn with_blows<T>(of: impl FnOnce() -> T) -> T {
        let blow = |node, coordinate| (node, Impulse { coordinate, parameter: 0 });
        GIVEN.with_borrow_mut(|given| *given = vec![blow(4, 4), blow(5, 5), blow(12, 4)]);
        let done = of();
        GIVEN.with_borrow_mut(Vec::clear);
        done
    }

    fn inputs(system: &System) -> [Inputs; 2] {
        let mut plain = Inputs::at_rest(system, Grid::uniform(16, 0.02));
        plain.controls.iter_mut().enumerate().for_each(|(k, u)| *u = (k as f64).sin());
        let grid = Grid::composed(4, 0.05, Composition::Suzuki4);
        let mut composed = Inputs::at_rest(system, grid);
        composed.controls.fill(0.5);
        [plain, composed]
    }

    fn direction(inputs: &Inputs, seed: usize) -> Inputs {
        let mut direction = inputs.no_change();
        for (k, input) in Input::all(inputs).into_iter().enumerate() {
            let size = if matches!(input, Input::Step(_)) { 0.01 } else { 0.3 };
            *input.of(&mut direction) = size * ((seed + 7 * k) as f64).sin();
        }
        direction
    }

    fn along(gradient: &Gradient, direction: &Inputs) -> f64 {
        let mut own = direction.clone();
        Input::all(direction).into_iter().map(|input| *input.of(&mut own) * input.in_gradient(gradient)).sum()
    }

    #[test]
    fn gradients_are_those_of_complex_step() {
        with_blows(|| {
            for (sum, feet) in [(Sum::Plain, 1), (Sum::Integral, 1), (Sum::Terminal, 1), (Sum::Integral, 2)] {
                let system = pendulum(sum, feet);
                for (inputs, settings) in
                    inputs(&system).iter().flat_map(|inputs| settings().map(|settings| (inputs, settings)))
                {
                    let mut solver = Solver::new(&system, settings);
                    solver.simulate(inputs).expect("a motion");
                    let gradient = solver.gradient().expect("a gradient").clone();
                    let mut lifted = LiftedSolver::<Cx>::new(&system, inputs, settings).expect("a motion");
                    let largest =
                        Input::all(inputs).iter().fold(0.0f64, |most, input| most.max(input.in_gradient(&gradient).abs()));
                    for input in Input::all(inputs) {
                        let mut moved = inputs.lift::<Cx>();
                        input.of(&mut moved).add_to_part(1, 1e-30);
                        lifted.simulate(&moved).expect("the same motion");
                        let (own, reference) =
                            (input.in_gradient(&gradient), lifted.cost().expect("a cost").part(1) / 1e-30);
                        let error = (own - reference).abs() / largest.max(1.0);
                        assert!(error < 1e-12, "{input:?}: {own} for {reference} with {settings:?}");
                    }
                    let bytes = 40 * system.bytes_per_node(&settings);
                    let long = LongSolver::new(&system, settings, bytes).gradient(inputs).expect("a gradient").clone();
                    assert!(long == gradient, "checkpoints with {settings:?}");
                }
            }
        });
    }

    #[test]
    fn products_with_the_hessian_are_those_of_hyper_dual_numbers() {
        with_blows(|| {
            let system = pendulum(Sum::Integral, 2);
            for (inputs, settings) in inputs(&system).iter().flat_map(|inputs| settings().map(|settings| (inputs, settings)))
            {
                let (a, b) = (direction(inputs, 1), direction(inputs, 1001));
                let mut solver = Solver::new(&system, settings);
                solver.simulate(inputs).expect("a motion");
                let of_a = solver.hessian_product(&a).expect("a product").clone();
                let mut lifted = LiftedSolver::<Hyper>::new(&system, inputs, settings).expect("a motion");
                let mut moved = inputs.lift::<Hyper>();
                for (part, direction) in [(1, &a), (2, &b)] {
                    let mut own = direction.clone();
                    Input::all(inputs).iter().for_each(|input| input.of(&mut moved).add_to_part(part, *input.of(&mut own)));
                }
                lifted.simulate(&moved).expect("the same motion");
                let (own, reference) = (along(&of_a, &b), lifted.cost().expect("a cost").part(3));
                assert!((own - reference).abs() < 1e-10 * reference.abs(), "{own} for {reference} with {settings:?}");
            }
        });
    }

    #[test]
    fn a_blow_changes_the_momentum_by_itself() {
        let system = pendulum(Sum::Plain, 1);
        let [inputs, _] = inputs(&system);
        let run = || crate::simulate(&system, &inputs, Settings::default()).expect("a motion");
        let (struck, free) = (with_blows(run), run());
        assert_eq!(
            struck.q.columns(0, 5),
            free.q.columns(0, 5),
            "nothing happens before the first blow, and q does not jump"
        );
        let jump = &struck.p_star - &free.p_star;
        assert!((jump[(4, 4)] - 0.7).abs() < 1e-12 && struck.v.column(4) != free.v.column(4));
        let phi_dot = struck.phi_dot(&system, &inputs).expect("dΦ/dt");
        assert!(phi_dot.amax() < 1e-12, "{phi_dot}");
    }
}
