//! Random scenes: the gradient is exact, errors are typed, nothing panics, nothing is NaN.
//!
//! `RANDOM_SCENES=2000 cargo test --release --test random -- --nocapture` tries more of them and prints what became of them.

#[path = "../common/bench.rs"]
#[allow(dead_code)]
mod bench;
mod build;
mod bytes;
mod crossed;
mod description;
mod elements;
mod exact;
mod impacts;
mod located;
#[path = "../scenes/elements.rs"]
#[allow(dead_code)]
mod parts;
mod regular;

use bytes::Bytes;
use description::Description;
use exact::Moved;
use hamiltonian_adjoint::Error;
use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// How many scenes a property is tried on, in units of what `RANDOM_SCENES` says.
fn cases() -> u32 {
    std::env::var("RANDOM_SCENES").ok().and_then(|count| count.parse().ok()).unwrap_or(450)
}

/// Tries a property on random values, the same ones in every run; a failure is shrunk.
fn try_all<S: Strategy>(cases: u32, strategy: S, property: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    if let Err(failure) = TestRunner::new_with_rng(config, rng).run(&strategy, property) {
        panic!("{failure}");
    }
}

/// What became of the scenes, and how exact the gradients were.
#[derive(Default)]
struct Tally {
    counts: RefCell<BTreeMap<String, usize>>,
    errors: RefCell<Vec<f64>>,
}

/// A gradient that agrees with complex step.
const EXACT: &str = "simulated, gradient exact";
/// A motion that cannot be compared, because the complex simulation does not converge or because it runs away.
const NO_REFERENCE: &str = "simulated, without a reference";

/// A motion that lost digits, but no more than its report says.
const TOLD: &str = "simulated, digits lost as reported";

/// A gradient from parts of a motion that are computed again.
const CHECKPOINTS: &str = "from checkpoints";

impl Tally {
    fn count(&self, what: &str) {
        *self.counts.borrow_mut().entry(what.to_string()).or_default() += 1;
    }

    fn count_error(&self, error: &Error) {
        let whole = error.to_string();
        // Up to the first name or number.
        self.count(whole.split(|c: char| "`(:;".contains(c) || c.is_ascii_digit()).next().unwrap_or_default());
    }

    fn share(&self, what: &str) -> f64 {
        let counts = self.counts.borrow();
        let all: usize = counts.values().sum();
        counts.get(what).map_or(0.0, |&count| count as f64 / all as f64)
    }

    fn print(&self, title: &str) {
        println!("{title}");
        for (what, count) in self.counts.borrow().iter() {
            println!("  {count:6} {what}");
        }
        let mut errors = self.errors.borrow().clone();
        errors.sort_by(f64::total_cmp);
        if let Some(last) = errors.len().checked_sub(1) {
            let at = |share: f64| errors[(share * last as f64) as usize];
            println!("  relative error: median {:.1e}, 99 % {:.1e}, largest {:.1e}", at(0.5), at(0.99), at(1.0));
        }
    }

    /// Asserts of a scene that its gradient is exact, unless it is refused for one of the reasons that it may have.
    fn try_one(&self, description: &Description, legitimate: fn(&Error) -> bool) -> Result<(), TestCaseError> {
        let moved = match exact::run(description).map_err(TestCaseError::fail)? {
            Ok(moved) => moved,
            Err(error) if legitimate(&error) => {
                self.count_error(&error);
                return Ok(());
            }
            Err(error) => return Err(TestCaseError::fail(format!("{error:?}"))),
        };
        self.compare(description, &moved)
    }

    /// Asserts that a gradient is exact, or as exact as its report says.
    fn compare(&self, description: &Description, moved: &Moved) -> Result<(), TestCaseError> {
        let Ok(Some(found)) = exact::disagreement(description, moved) else {
            self.count(NO_REFERENCE);
            return Ok(());
        };
        if found.is_exact() {
            self.errors.borrow_mut().push(found.error);
            self.count(EXACT);
        } else if found.is_told() {
            self.count(TOLD);
        } else {
            return Err(TestCaseError::fail(format!("{:e}: {}", found.error, found.what)));
        }
        Ok(())
    }
}

/// Singular configurations and steps that are too long come up in any random motion.
fn accident(error: &Error) -> bool {
    matches!(
        error,
        Error::Newton { .. } | Error::Projection { .. } | Error::SingularStep { .. } | Error::SingularConfiguration { .. }
    )
}

/// Dependent constraints may be too many, or be contradicted by the drift of positions.
fn unsound(error: &Error) -> bool {
    matches!(error, Error::DependentConstraints { .. } | Error::ContradictoryConstraints { .. })
}

#[test]
fn gradients_of_random_scenes_are_exact() {
    let tally = Tally::default();
    try_all(10 * cases(), regular::description(), |description| tally.try_one(&description, accident));
    tally.print("random scenes");
    assert!(tally.share(EXACT) >= 0.9, "too few of the scenes can be simulated");
    assert!(tally.share(NO_REFERENCE) + tally.share(TOLD) <= 0.01, "too few of the motions can be compared");
}

#[test]
fn products_of_random_scenes_are_symmetric_and_exact() {
    let tally = Tally::default();
    let property = |description: Description| {
        let Ok(Ok(moved)) = exact::run(&description) else { return Ok(()) };
        match exact::disagreement_of_products(&description, &moved) {
            Ok(None) => tally.count("without products"),
            // A rough motion may not be followed in other numbers.
            Err(_) => tally.count(NO_REFERENCE),
            Ok(Some(found)) if found.is_exact() => {
                tally.errors.borrow_mut().push(found.error);
                tally.count(EXACT);
            }
            Ok(Some(found)) if found.is_told() => tally.count(TOLD),
            Ok(Some(found)) => return Err(TestCaseError::fail(format!("{:e}: {}", found.error, found.what))),
        }
        Ok(())
    };
    try_all(cases(), regular::description(), property);
    tally.print("products of random scenes");
    assert!(tally.share(EXACT) >= 0.5, "too few of the scenes have products");
    assert!(tally.share(NO_REFERENCE) + tally.share(TOLD) <= 0.02, "too few of the products can be compared");
}

#[test]
fn gradients_of_random_scenes_with_dependent_constraints_are_exact() {
    let tally = Tally::default();
    try_all(cases(), regular::redundant(), |description| {
        tally.try_one(&description, |error| accident(error) || unsound(error))
    });
    tally.print("random scenes with dependent constraints");
    assert!(tally.share(TOLD) <= 0.01, "too few of the gradients are exact");
}

#[test]
fn no_scene_panics_or_gives_numbers_that_are_not_finite() {
    let tally = Tally::default();
    try_all(10 * cases(), proptest::collection::vec(proptest::num::u8::ANY, 0..700), |bytes| {
        let description = Bytes(&bytes).description();
        match exact::run(&description) {
            Ok(Ok(_)) => tally.count("simulated"),
            Ok(Err(error)) => tally.count_error(&error),
            Err(defect) => return Err(TestCaseError::fail(format!("{defect} in {description:#?}"))),
        }
        Ok(())
    });
    tally.print("scenes of random bytes");
    assert!(tally.share("simulated") >= 0.1, "too few of the scenes get far");
}

#[test]
fn gradients_are_exact_with_restarts_halved_steps_and_grids_of_all_kinds_and_the_same_from_checkpoints() {
    let (tally, budgets) = (Tally::default(), Tally::default());
    try_all(cases(), crossed::description(), |description| {
        let moved = match exact::run(&description).map_err(TestCaseError::fail)? {
            Ok(moved) => moved,
            Err(error) => {
                tally.count_error(&error);
                return Ok(());
            }
        };
        let fitting = crossed::compare_with_checkpoints(&description, &moved).map_err(TestCaseError::fail)?;
        budgets.count(if fitting > 1 { CHECKPOINTS } else { "in one piece" });
        tally.compare(&description, &moved)
    });
    tally.print("random scenes with restarts, halved steps and grids of all kinds");
    budgets.print("the same within budgets of memory");
    assert!(tally.share(EXACT) >= 0.9, "too few of the scenes can be simulated");
    assert!(budgets.share(CHECKPOINTS) >= 0.3, "too few of the motions have checkpoints");
}

/// Compares products with the Hessian, and counts how this ended.
fn count_products(products: &Tally, description: &Description, moved: &Moved) -> Result<(), TestCaseError> {
    match exact::disagreement_of_products(description, moved) {
        Ok(Some(found)) if found.is_exact() => products.count(EXACT),
        Ok(Some(found)) if found.is_told() => products.count(TOLD),
        Ok(Some(found)) => return Err(TestCaseError::fail(format!("{:e}: {}", found.error, found.what))),
        Ok(None) | Err(_) => products.count(NO_REFERENCE),
    }
    Ok(())
}

#[test]
fn gradients_and_products_with_located_events_are_exact_and_the_same_from_checkpoints() {
    let (tally, products) = (Tally::default(), Tally::default());
    try_all(cases(), located::scene_with_events(), |(description, events)| {
        let moved = match located::run(&description, &events).map_err(TestCaseError::fail)? {
            Ok(moved) => moved,
            Err(None) => return Ok(()),
            Err(Some(error)) => {
                let is_event = matches!(
                    error,
                    Error::EventNotReached { .. } | Error::EventAtEnd { .. } | Error::EventNotLocated { .. }
                );
                let is_known = is_event || accident(&error) || unsound(&error);
                tally.count_error(&error);
                return if is_known { Ok(()) } else { Err(TestCaseError::fail(format!("{error:?}"))) };
            }
        };
        crossed::compare_with_checkpoints(&description, &moved).map_err(TestCaseError::fail)?;
        tally.compare(&description, &moved)?;
        count_products(&products, &description, &moved)
    });
    tally.print("random scenes with located events");
    products.print("their products");
    assert!(tally.share(EXACT) >= 0.85, "too few of the events are found");
    assert!(products.share(EXACT) >= 0.95, "too few of the products can be compared");
}

#[test]
fn gradients_and_products_with_impacts_and_open_constraints_are_exact_and_the_same_from_checkpoints() {
    let (tally, products, kinds) = (Tally::default(), Tally::default(), Tally::default());
    try_all(2 * cases() / 3, impacts::scene_with_impacts(), |(description, sought)| {
        let moved = match impacts::run(&description, &sought, |kind| kinds.count(kind)).map_err(TestCaseError::fail)? {
            Ok(moved) => moved,
            Err(None) => return Ok(()),
            Err(Some(error)) => {
                let is_known = accident(&error) || unsound(&error) || impacts::is_of_events(&error);
                tally.count_error(&error);
                return if is_known { Ok(()) } else { Err(TestCaseError::fail(format!("{error:?}"))) };
            }
        };
        crossed::compare_with_checkpoints(&description, &moved).map_err(TestCaseError::fail)?;
        tally.compare(&description, &moved)?;
        if description.run.seed % 2 == 0 {
            return Ok(());
        }
        count_products(&products, &description, &moved)
    });
    tally.print("random scenes with impacts and open constraints");
    products.print("their products");
    kinds.print("what happens at their events");
    // Constraints that close often leave no freedom.
    assert!(tally.share(EXACT) >= 0.7, "too few of the motions can be compared");
    assert!(products.share(EXACT) >= 0.95, "too few of the products can be compared");
}
