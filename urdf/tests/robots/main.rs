//! Robots from files: their accelerations, their options, and the errors of malformed files.

mod accelerations;
mod errors;
mod files;
mod options;
mod random;
#[path = "../../reference/state.rs"]
mod state;

/// The text of one of the member's own files.
pub fn text(robot: &str) -> &'static str {
    match robot {
        "arm" => include_str!("../../robots/arm.urdf"),
        "linkage" => include_str!("../../robots/linkage.urdf"),
        _ => include_str!("../../robots/loose.urdf"),
    }
}
