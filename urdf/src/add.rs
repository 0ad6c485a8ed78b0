//! From a [`Robot`] to the bodies and joints of a scene.

use hamiltonian_adjoint::spatial::{Body, Inertia, Marker};
use hamiltonian_adjoint::{Coordinate, Scene};
use nalgebra::{Rotation3, Unit, Vector3};

use crate::added::{Added, Base, Damping, Follower, Locked, Moving, Options};
use crate::error::{Doubt, Error, Fault};
use crate::inertia;
use crate::mimic::{Cause, State, massive, states};
use crate::robot::{Joint, Kind, Robot};
use crate::tree::Tree;

impl Robot {
    /// Adds the robot to a scene. Set gravity with [`Spatial::gravity`](hamiltonian_adjoint::spatial::Spatial::gravity).
    ///
    /// # Errors
    /// Links and joints that do not form a tree, impossible inertias, joints that cannot follow others, and joints that cannot be locked. The scene is then
    /// unchanged.
    pub fn add_to(&self, scene: &mut Scene, options: &Options) -> Result<Added, Error> {
        let tree = Tree::new(self)?;
        let taken = tree.joints.get("base").filter(|_| options.base == Base::Floating);
        if let Some(&taken) = taken {
            let fault = Fault::DuplicateName { kind: "joint", name: "base".into() };
            return Err(Error::new(self.joints[taken].at, fault));
        }
        let states = states(self, &tree, options)?;
        let doubts = self.doubts(options)?;
        self.joints.iter().try_for_each(check)?;
        let adding = Adding { robot: self, tree, states, options };
        let mut added = Added { prefix: options.prefix.clone(), ..Added::default() };
        adding.add_links(scene, &doubts, &mut added);
        // A joint may follow one that is added later, so all coordinates are added first.
        let coordinates = adding.coordinates(scene);
        adding.add_joints(scene, &coordinates, &mut added);
        if options.damping == Damping::File {
            adding.add_damping(scene, &coordinates);
        }
        Ok(added)
    }

    /// The reasons why no distribution of mass has the inertias of the links.
    fn doubts(&self, options: &Options) -> Result<Vec<Option<Doubt>>, Error> {
        let doubts = self.links.iter().map(inertia::doubt).collect::<Result<Vec<_>, _>>()?;
        let first = self.links.iter().zip(&doubts).find_map(|(link, doubt)| doubt.map(|doubt| (link, doubt)));
        match first {
            Some((link, doubt)) if !options.accept_impossible_inertias => {
                Err(Error::new(link.at, Fault::Inertia { link: link.name.clone(), doubt }))
            }
            _ => Ok(doubts),
        }
    }
}

/// A robot that is added to a scene.
struct Adding<'r> {
    robot: &'r Robot,
    tree: Tree,
    states: Vec<State>,
    options: &'r Options,
}

impl Adding<'_> {
    fn name(&self, name: &str) -> String {
        format!("{}{name}", self.options.prefix)
    }

    /// Adds the bodies and the joint of the base.
    fn add_links(&self, scene: &mut Scene, doubts: &[Option<Doubt>], added: &mut Added) {
        let mut space = scene.spatial();
        for (link, doubt) in self.robot.links.iter().zip(doubts) {
            let inertia = link.inertial.map_or_else(Inertia::none, |inertial| inertial.in_link());
            let inertia = if doubt.is_some() { inertia.unchecked() } else { inertia };
            added.doubts.extend(doubt.map(|doubt| (link.name.clone(), doubt)));
            added.links.push((link.name.clone(), space.body(&self.name(&link.name), inertia)));
        }
        let (ground, root) = (Body::GROUND.origin(), added.links[self.tree.root].1.origin());
        let is_floating = self.options.base == Base::Floating;
        match is_floating && massive(self.robot, &self.tree)[self.tree.root] {
            true => added.base = Some(space.free(&self.name("base"), ground, root)),
            false => space.fixed(&self.name("base"), ground, root),
        }
        let cannot_move = is_floating && added.base.is_none();
        added.locked.extend(cannot_move.then(|| Locked { name: "base".into(), value: 0.0, cause: Cause::NoMass }));
    }

    /// Adds the coordinates of the joints that move and have one.
    fn coordinates(&self, scene: &mut Scene) -> Vec<Option<Coordinate>> {
        let mut coordinates = vec![None; self.robot.joints.len()];
        for &which in &self.tree.outward {
            let joint = &self.robot.joints[which];
            if self.states[which] == State::Moves && joint.kind.has_one_coordinate() {
                let what = if joint.kind == Kind::Prismatic { "offset" } else { "angle" };
                let [coordinate] = scene.coordinates(&self.name(&joint.name), [what]);
                coordinates[which] = Some(coordinate);
            }
        }
        coordinates
    }

    fn add_joints(&self, scene: &mut Scene, coordinates: &[Option<Coordinate>], added: &mut Added) {
        for &which in &self.tree.outward {
            let joint = &self.robot.joints[which];
            let name = joint.name.clone();
            let ends = self.tree.ends[which].map(|link| added.links[link].1);
            let of = match self.states[which] {
                State::Fixed => Law::Constant(0.0),
                State::Locked { value, cause } => {
                    added.locked.push(Locked { name, value, cause });
                    Law::Constant(value)
                }
                State::Follows { leader, factor, offset } => {
                    added.followers.push(Follower { name, of: self.robot.joints[leader].name.clone(), factor, offset });
                    coordinates[leader].map_or(Law::Constant(offset), |of| Law::Linear(of, [factor, offset]))
                }
                State::Moves => coordinates[which].map_or(Law::Several, |of| Law::Linear(of, [1.0, 0.0])),
            };
            let several = add_joint(scene, &self.name(&joint.name), (joint, of), ends);
            if self.states[which] == State::Moves {
                let coordinates = several.into_iter().chain(coordinates[which]).collect();
                let Joint { kind, limit, damping, friction, .. } = *joint;
                added.joints.push(Moving { name: joint.name.clone(), kind, coordinates, limit, damping, friction });
            }
        }
    }

    /// −d v on every coordinate, with d = Σ d_j r_j² over the joints that follow it with the factors r_j.
    fn add_damping(&self, scene: &mut Scene, coordinates: &[Option<Coordinate>]) {
        let mut damping = vec![0.0; coordinates.len()];
        for (which, joint) in self.robot.joints.iter().enumerate() {
            let (onto, factor) = match self.states[which] {
                State::Follows { leader, factor, .. } => (leader, factor),
                _ => (which, 1.0),
            };
            damping[onto] += joint.damping * factor * factor;
        }
        for (which, damping) in damping.into_iter().enumerate().filter(|(_, damping)| *damping != 0.0) {
            if let Some(coordinate) = coordinates[which] {
                let name = format!("damping of {}", self.name(&self.robot.joints[which].name));
                scene.axis_spring_damper(&name, coordinate, 0.0, 0.0, damping);
            }
        }
    }
}

/// The motion of a joint.
enum Law {
    /// It keeps a value.
    Constant(f64),
    /// A factor times a coordinate plus an offset.
    Linear(Coordinate, [f64; 2]),
    /// It has several coordinates.
    Several,
}

/// Adds a joint, and returns its coordinates if it has several.
fn add_joint(scene: &mut Scene, name: &str, (joint, law): (&Joint, Law), ends: [Body; 2]) -> Vec<Coordinate> {
    let (a, b) = markers(joint, ends, if let Law::Constant(value) = law { value } else { 0.0 });
    let mut space = scene.spatial();
    match (law, joint.kind) {
        (Law::Linear(of, numbers), Kind::Prismatic) => space.dependent_prismatic(name, a, b, of, numbers),
        (Law::Linear(of, numbers), _) => space.dependent_revolute(name, a, b, of, numbers),
        (Law::Several, Kind::Planar) => {
            let planar = space.planar(name, a, b);
            return [&planar.offsets[..], &[planar.angle]].concat();
        }
        (Law::Several, Kind::Floating) => {
            let free = space.free(name, a, b);
            return [&free.position[..], &free.orientation].concat();
        }
        _ => space.fixed(name, a, b),
    }
    Vec::new()
}

/// # Errors
/// An axis without a direction, or negative damping.
fn check(joint: &Joint) -> Result<(), Error> {
    let has_axis = !matches!(joint.kind, Kind::Fixed | Kind::Floating);
    if has_axis && !joint.axis.iter().fold(0.0, |sum: f64, x| sum.max(x.abs())).is_normal() {
        return Err(Error::new(joint.at, Fault::Axis { joint: joint.name.clone(), axis: joint.axis }));
    }
    if !(joint.damping >= 0.0 && joint.damping.is_finite()) {
        let (of, value) = (format!("joint '{}'", joint.name), joint.damping);
        return Err(Error::new(
            joint.at,
            Fault::Value { of, what: "damping", value, must_be: "finite, and positive or zero" },
        ));
    }
    Ok(())
}

/// The markers of a joint at its parent and its child. Their z axes are the axis of the joint. `value` is the value at which the joint is locked: the
/// outer marker is turned about its axis, or shifted along it.
fn markers(joint: &Joint, [parent, child]: [Body; 2], value: f64) -> (Marker, Marker) {
    let (rotation, at) = (joint.origin.rotation(), joint.origin.point());
    if matches!(joint.kind, Kind::Fixed | Kind::Floating) {
        return (parent.at(joint.origin.xyz).turned(joint.origin.rpy), child.origin());
    }
    let axis = Vector3::from(joint.axis);
    let axis = Unit::new_normalize(axis / axis.amax());
    // The coordinate axis after the one closest to the axis is not parallel to it.
    let mut toward = Vector3::zeros();
    toward[(axis.iamax() + 1) % 3] = 1.0;
    let (turn, shift) = match joint.kind {
        Kind::Prismatic => (Rotation3::identity(), axis.scale(value)),
        _ => (Rotation3::from_axis_angle(&axis, value), Vector3::zeros()),
    };
    let [at, z, x]: [[f64; 3]; 3] =
        [at + rotation * shift, rotation * axis.into_inner(), rotation * (turn * toward)].map(Into::into);
    let inner: [[f64; 3]; 2] = [axis.into_inner(), toward].map(Into::into);
    (parent.at(at).along_and_toward(z, x), child.origin().along_and_toward(inner[0], inner[1]))
}
