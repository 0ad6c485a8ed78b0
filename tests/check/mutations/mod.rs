//! Forty-nine mistakes, one each in right hand-derived blocks: every one must be caught, and most called by their name.

mod elements;
mod energies;
mod forces;
mod joints;
mod narrow;
mod new_user;
mod steps;

use hamiltonian_adjoint::check::{self, Mistake, Report};

/// What was done, where, what it should be called, and the report.
type Case = (&'static str, &'static str, Mistake, Report);

const ARMS: [f64; 4] = [0.5, 0.1, -0.4, 0.2];
const ROD: [f64; 5] = [0.5, 0.1, -0.4, 0.2, 1.3];
const DAMPER: [f64; 5] = [0.5, 0.1, -0.4, 0.2, 3.0];
const SPRING: [f64; 6] = [0.5, 0.1, -0.4, 0.2, 40.0, 0.3];
const PENDULUM: [f64; 4] = [0.8, 0.4, 1.1, 0.9];
const NAMES: [&str; 6] = ["cart.x", "cart.y", "cart.φ", "link 1.x", "link 1.y", "link 1.φ"];

fn edit<T>(mut value: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut value);
    value
}

#[test]
fn every_mistake_is_caught_and_most_are_named() {
    let cases: Vec<Case> =
        [joints::cases(), forces::cases(), energies::cases(), steps::cases()].into_iter().flatten().collect();
    let mut named = 0;
    println!("| # | block | mistake made | caught | diagnosis |\n|---|---|---|---|---|");
    for (i, (mistake, place, expected, report)) in cases.iter().enumerate() {
        let diagnoses = &report.blocks[0].diagnoses;
        let right = diagnoses.len() == 1 && diagnoses[0].mistake == *expected && *expected != Mistake::Unexplained;
        named += usize::from(right);
        let texts: Vec<&str> = diagnoses.iter().map(|d| d.text.as_str()).collect();
        let (caught, mark) = (if report.passed() { "NO" } else { "yes" }, if right { "" } else { " (not named)" });
        println!("| {} | {place} | {mistake} | {caught} | {}{mark} |", i + 1, texts.join("; "));
        for note in report.blocks[0].notes.iter() {
            println!("       note: {note}");
        }
    }
    let caught = cases.iter().filter(|(.., report)| report.verdict() == check::Verdict::Wrong).count();
    println!("{} mistakes, {caught} caught, {named} named right", cases.len());
    assert_eq!(caught, cases.len());
    assert!(named == cases.len(), "{named} of {} named", cases.len());
}
