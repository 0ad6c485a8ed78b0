//! Random mutations of files: reading them never panics.

use hamiltonian_adjoint::Scene;
use urdf::{Options, Robot};

use crate::text;

/// A linear congruential generator.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % bound.max(1)
    }
}

/// Of so many scenes one is compiled, which takes longer than all the rest.
const EVERY: usize = 5;

/// Texts that a mutation may insert.
const PIECES: [&str; 16] = [
    "<",
    ">",
    "/>",
    "\"",
    "&",
    "-",
    "0",
    "1e308",
    "NaN",
    "<link name=\"x\"/>",
    "mimic",
    "<!--",
    "xmlns:a=\"b\"",
    "\u{0}",
    "fixed",
    "é",
];

/// Removes, copies or inserts a piece, or exchanges the values of two attributes.
fn mutate(text: &mut Vec<char>, random: &mut Random) {
    let (at, length) = (random.below(text.len()), 1 + random.below(30));
    match random.below(6) {
        0 => drop(text.drain(at..(at + length).min(text.len()))),
        1 => {
            let (piece, to) = (text[at..(at + length).min(text.len())].to_vec(), random.below(text.len()));
            drop(text.splice(to..to, piece));
        }
        2 => drop(text.splice(at..at, PIECES[random.below(PIECES.len())].chars())),
        _ => {
            let whole: String = text.iter().collect();
            let mut parts: Vec<&str> = whole.split('"').collect();
            // Every second part is a value, if there are quotes at all.
            let [first, second] = [(); 2].map(|()| (2 * random.below(parts.len() / 2) + 1) % parts.len());
            parts.swap(first, second);
            *text = parts.join("\"").chars().collect();
        }
    }
}

#[test]
fn mutated_files_never_panic() {
    let (mut random, mut read, mut added) = (Random(1), 0, 0);
    for run in 0..4000 {
        let mut text: Vec<char> = text(["arm", "linkage", "loose"][run % 3]).chars().collect();
        (0..1 + random.below(3)).for_each(|_| mutate(&mut text, &mut random));
        let text: String = text.into_iter().collect();
        let Ok(robot) = Robot::from_text(&text) else { continue };
        read += 1;
        let mut scene = Scene::new();
        let Ok(parts) = robot.add_to(&mut scene, &Options::default()) else { continue };
        parts.drive(&mut scene);
        added += 1;
        // The scene may be impossible, for example without any joint that moves.
        let _ = if added % EVERY == 0 { scene.compile().map(|_| ()) } else { Ok(()) };
    }
    assert!(read > 300 && added > 100 && added < read, "{read} of 4000 mutated files were read and {added} added");
}
