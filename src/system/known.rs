//! The node problem's data: everything that a scheme says of the unknowns of a node before they are found.
//!
//! Find (v, σ) with 𝓛_v − h (𝓛_q + Q) = p̄ and dΦ/dt = 0 at q = q̄ + h v.

/// The known part (q̄, p̄, h) of a node problem, and σ₋ for compliances.
#[derive(Clone, Copy)]
pub(crate) struct KnownPart<'a> {
    pub(crate) h: f64,
    pub(crate) q: &'a [f64],
    pub(crate) p_star: &'a [f64],
    pub(crate) sigma: &'a [f64],
}

/// What stays the same while a node is solved.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) u: &'a [f64],
    pub(crate) t: f64,
    pub(crate) design: &'a [f64],
}
