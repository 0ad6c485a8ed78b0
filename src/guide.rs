#![doc = include_str!("guide_links.md")]
#![doc = include_str!("../docs/README.md")]

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/tutorial.md")]
pub mod tutorial {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/reproduction.md")]
pub mod reproduction {}

#[doc = include_str!("../docs/paper-equations.md")]
pub mod paper_equations {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/checking-derivatives.md")]
pub mod checking_derivatives {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/own-elements.md")]
pub mod own_elements {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/parameters-and-starts.md")]
pub mod parameters_and_starts {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/optimisation.md")]
pub mod optimisation {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/long-and-hard-motions.md")]
pub mod long_and_hard_motions {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/is-it-true.md")]
pub mod is_it_true {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/space.md")]
pub mod space {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/impacts.md")]
pub mod impacts {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/animations-and-files.md")]
pub mod animations_and_files {}

#[cfg_attr(not(feature = "files"), doc = "Needs the feature `files`.")]
#[cfg_attr(feature = "files", doc = include_str!("guide_links.md"))]
#[cfg_attr(feature = "files", doc = include_str!("../docs/scene-files.md"))]
pub mod scene_files {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/command-line.md")]
pub mod command_line {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/python.md")]
pub mod python {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/accuracy-and-speed.md")]
pub mod accuracy_and_speed {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/comparison.md")]
pub mod comparison {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/derivation.md")]
pub mod derivation {}

#[doc = include_str!("guide_links.md")]
#[doc = include_str!("../docs/programs.md")]
pub mod programs {}
