//! [`State`]: joints that move, that follow others, and that are locked.

use crate::added::Options;
use crate::error::{Error, Fault, Why};
use crate::robot::{Kind, Robot};
use crate::tree::Tree;

/// What happens to a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum State {
    /// It has no coordinates.
    Fixed,
    /// It has coordinates of its own.
    Moves,
    /// Its value is a factor times the coordinate of another joint plus an offset.
    Follows { leader: usize, factor: f64, offset: f64 },
    /// It keeps a value.
    Locked { value: f64, cause: Cause },
}

/// The reason why a joint is locked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The options lock it.
    Options,
    /// It follows a joint that is fixed or locked, or with the factor zero.
    Follows,
    /// Neither it nor the joints that follow it carry any mass, so its motion is undetermined.
    NoMass,
}

/// The states of all joints.
///
/// # Errors
/// Joints that should be locked but do not exist, and joints that cannot follow others.
pub(crate) fn states(robot: &Robot, tree: &Tree, options: &Options) -> Result<Vec<State>, Error> {
    let kinds = robot.joints.iter().map(|joint| if joint.kind == Kind::Fixed { State::Fixed } else { State::Moves });
    let mut own: Vec<State> = kinds.collect();
    for (name, value) in &options.locked {
        let unknown = || Error::without_position(Fault::UnknownLock { joint: name.clone() });
        let &which = tree.joints.get(name).ok_or_else(unknown)?;
        let joint = &robot.joints[which];
        let has_value = joint.kind.has_one_coordinate() && value.is_finite();
        if !has_value && *value != 0.0 {
            return Err(Error::new(joint.at, Fault::Lock { joint: name.clone(), value: *value }));
        }
        own[which] = State::Locked { value: *value, cause: Cause::Options };
    }
    let of = |which: usize| match options.ignore_mimic || own[which] != State::Moves {
        true => Ok(None),
        false => leader(robot, tree, which),
    };
    let leaders = (0..own.len()).map(of).collect::<Result<Vec<_>, _>>()?;
    let mut states = own.clone();
    for (which, state) in states.iter_mut().enumerate().filter(|(which, _)| leaders[*which].is_some()) {
        *state = following(robot, &leaders, &own, which)?;
    }
    lock_massless(robot, tree, &mut states);
    Ok(states)
}

fn refused(robot: &Robot, which: usize, why: Why) -> Error {
    let joint = &robot.joints[which];
    let of = joint.mimic.as_ref().map_or_else(String::new, |mimic| mimic.joint.clone());
    Error::new(joint.at, Fault::Mimic { joint: joint.name.clone(), of, why })
}

/// The joint that another one follows directly.
fn leader(robot: &Robot, tree: &Tree, which: usize) -> Result<Option<usize>, Error> {
    let joint = &robot.joints[which];
    let Some(mimic) = &joint.mimic else { return Ok(None) };
    let &leader = tree.joints.get(&mimic.joint).ok_or_else(|| refused(robot, which, Why::Unknown))?;
    let has_value = |kind: Kind| kind.has_one_coordinate() || kind == Kind::Fixed;
    match has_value(joint.kind) && has_value(robot.joints[leader].kind) {
        true => Ok(Some(leader)),
        false => Err(refused(robot, which, Why::Coordinates)),
    }
}

/// A joint that follows others: q = factor q_leader + offset, composed along the chain.
fn following(robot: &Robot, leaders: &[Option<usize>], own: &[State], which: usize) -> Result<State, Error> {
    let (mut factor, mut offset, mut at, mut steps) = (1.0, 0.0, which, 0);
    while let Some(leader) = leaders[at] {
        let mimic = robot.joints[at].mimic.as_ref().map_or((1.0, 0.0), |mimic| (mimic.multiplier, mimic.offset));
        offset += factor * mimic.1;
        factor *= mimic.0;
        (at, steps) = (leader, steps + 1);
        if steps > own.len() {
            return Err(refused(robot, which, Why::Circle));
        }
    }
    let locked = |value: f64| State::Locked { value, cause: Cause::Follows };
    Ok(match own[at] {
        State::Locked { value, .. } => locked(factor * value + offset),
        State::Moves if factor != 0.0 => State::Follows { leader: at, factor, offset },
        _ => locked(offset),
    })
}

/// True for every link that is massive or carries a massive link.
pub(crate) fn massive(robot: &Robot, tree: &Tree) -> Vec<bool> {
    let mut is_massive: Vec<bool> =
        robot.links.iter().map(|link| link.inertial.is_some_and(|inertial| !inertial.is_none())).collect();
    for [parent, child] in tree.outward.iter().rev().map(|joint| tree.ends[*joint]) {
        is_massive[parent] |= is_massive[child];
    }
    is_massive
}

/// Locks joints that carry no mass, neither themselves nor by the joints that follow them.
fn lock_massless(robot: &Robot, tree: &Tree, states: &mut [State]) {
    let is_massive = massive(robot, tree);
    let mut is_moved: Vec<bool> = tree.ends.iter().map(|[_, child]| is_massive[*child]).collect();
    for (which, state) in states.iter().enumerate() {
        if let State::Follows { leader, .. } = state {
            is_moved[*leader] |= is_moved[which];
        }
    }
    for state in states.iter_mut() {
        if let State::Follows { leader, offset, .. } = *state
            && !is_moved[leader]
        {
            *state = State::Locked { value: offset, cause: Cause::NoMass };
        }
    }
    for (state, _) in states.iter_mut().zip(is_moved).filter(|(state, is_moved)| **state == State::Moves && !is_moved) {
        *state = State::Locked { value: 0.0, cause: Cause::NoMass };
    }
}
