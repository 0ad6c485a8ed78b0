//! [`Tree`]: how the joints of a robot connect its links.

use std::collections::HashMap;

use crate::error::{Error, Fault};
use crate::robot::{Joint, Robot};
use crate::scan::MAX_LINKS;

/// Numbers of links and joints instead of names.
pub(crate) struct Tree {
    /// The link that no joint carries.
    pub(crate) root: usize,
    /// The parent and the child of every joint.
    pub(crate) ends: Vec<[usize; 2]>,
    /// The joints, those closer to the root before those that they carry.
    pub(crate) outward: Vec<usize>,
    /// The numbers of the joints by their names.
    pub(crate) joints: HashMap<String, usize>,
}

impl Tree {
    /// # Errors
    /// Names that are missing or appear twice, and joints that do not form a tree.
    pub(crate) fn new(robot: &Robot) -> Result<Self, Error> {
        if robot.links.len().max(robot.joints.len()) > MAX_LINKS {
            let found = robot.links.len().max(robot.joints.len());
            return Err(Error::without_position(Fault::TooLarge { what: "links or joints", found, limit: MAX_LINKS }));
        }
        let links = numbered("link", robot.links.iter().map(|link| (&link.name, link.at)))?;
        let joints = numbered("joint", robot.joints.iter().map(|joint| (&joint.name, joint.at)))?;
        let ends = robot.joints.iter().map(|joint| ends(joint, &links)).collect::<Result<Vec<_>, _>>()?;
        let mut carrying: Vec<Option<usize>> = vec![None; robot.links.len()];
        let mut carried: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
        for (which, [parent, child]) in ends.iter().enumerate() {
            let joint = &robot.joints[which];
            if let Some(first) = carrying[*child].replace(which) {
                let (first, link) = (robot.joints[first].name.clone(), joint.child.clone());
                return Err(Error::new(joint.at, Fault::SecondParent { joint: joint.name.clone(), first, link }));
            }
            carried[*parent].push(which);
        }
        let root = root(robot, &carrying)?;
        let (mut outward, mut stack) =
            (Vec::with_capacity(ends.len()), carried[root].iter().rev().copied().collect::<Vec<_>>());
        let mut is_reached = vec![false; robot.links.len()];
        is_reached[root] = true;
        while let Some(joint) = stack.pop() {
            outward.push(joint);
            let child = ends[joint][1];
            is_reached[child] = true;
            stack.extend(carried[child].iter().rev());
        }
        match is_reached.iter().position(|is_reached| !is_reached) {
            Some(link) => Err(in_loop(robot, link)),
            None => Ok(Tree { root, ends, outward, joints }),
        }
    }
}

/// The numbers of parts by their names.
fn numbered<'r>(
    kind: &'static str,
    parts: impl Iterator<Item = (&'r String, crate::Position)>,
) -> Result<HashMap<String, usize>, Error> {
    let mut numbers = HashMap::new();
    for (which, (name, at)) in parts.enumerate() {
        if numbers.insert(name.clone(), which).is_some() {
            return Err(Error::new(at, Fault::DuplicateName { kind, name: name.clone() }));
        }
    }
    Ok(numbers)
}

fn ends(joint: &Joint, links: &HashMap<String, usize>) -> Result<[usize; 2], Error> {
    let end = |role: &'static str, link: &String| {
        let unknown = || Fault::UnknownLink { joint: joint.name.clone(), role, link: link.clone() };
        links.get(link).copied().ok_or_else(|| Error::new(joint.at, unknown()))
    };
    Ok([end("parent", &joint.parent)?, end("child", &joint.child)?])
}

/// The only link that no joint carries.
fn root(robot: &Robot, carrying: &[Option<usize>]) -> Result<usize, Error> {
    let mut roots = carrying.iter().enumerate().filter_map(|(link, joint)| joint.is_none().then_some(link));
    match (roots.next(), roots.next()) {
        (Some(root), None) => Ok(root),
        (Some(first), Some(second)) => {
            let links = [first, second].map(|link| robot.links[link].name.clone());
            Err(Error::new(robot.links[second].at, Fault::SeveralRoots { links }))
        }
        (None, _) if robot.links.is_empty() => Err(Error::without_position(Fault::NoLinks)),
        (None, _) => Err(in_loop(robot, 0)),
    }
}

fn in_loop(robot: &Robot, link: usize) -> Error {
    let link = &robot.links[link];
    Error::new(link.at, Fault::Loop { link: link.name.clone() })
}
