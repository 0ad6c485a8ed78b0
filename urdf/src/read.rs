//! From a text to the links and joints of a [`Robot`].

use roxmltree::{Document, Node, ParsingOptions};

use crate::error::{Error, Fault, Position};
use crate::robot::{Inertial, Joint, Kind, Limit, Link, Mimic, Pose, Robot};
use crate::scan::{Lines, MAX_NODES};

/// # Errors
/// A text that is not well-formed or no URDF, and numbers that are missing or not finite.
pub(crate) fn robot(text: &str) -> Result<Robot, Error> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, entity_resolver: None };
    let document = Document::parse_with_options(text, options).map_err(of_parser)?;
    let lines = Lines::new(text);
    let root = document.root_element();
    let name = root.tag_name().name();
    let whole = Part { node: root, of: "the robot".into(), lines: &lines };
    if name != "robot" {
        return Err(whole.error(Fault::NotRobot { found: short(name) }));
    }
    if let Some(xacro) = document.descendants().find(|node| node.is_element() && is_xacro(node)) {
        let element = format!("xacro:{}", short(xacro.tag_name().name()));
        return Err(Error::new(lines.position(xacro.range().start), Fault::Xacro { element }));
    }
    let mut robot = Robot { name: whole.attribute("name")?.into(), ..Robot::default() };
    for node in
        root.children().filter(|node| node.is_element() && node.tag_name().namespace() == root.tag_name().namespace())
    {
        let part = |kind: &str| -> Result<(Part, String), Error> {
            let part = Part { node, of: format!("a {kind}"), lines: &lines };
            let name = part.attribute("name")?.to_string();
            Ok((Part { of: format!("{kind} '{name}'"), ..part }, name))
        };
        match node.tag_name().name() {
            "link" => {
                let (part, name) = part("link")?;
                let inertial = part.child("inertial")?.map(|inertial| inertial.inertial()).transpose()?;
                robot.links.push(Link { name, inertial, at: part.position() });
            }
            "joint" => {
                let (part, name) = part("joint")?;
                robot.joints.push(part.joint(name)?);
            }
            _ => {}
        }
    }
    Ok(robot)
}

fn of_parser(error: roxmltree::Error) -> Error {
    let at = error.pos();
    let at = Position { line: at.row as usize, column: at.col as usize };
    Error::new(at, Fault::Xml { reason: error.to_string() })
}

fn is_xacro(node: &Node) -> bool {
    node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"))
}

/// The first 40 characters.
fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

/// An element and the part of the robot to which it belongs.
struct Part<'a, 'i> {
    node: Node<'a, 'i>,
    of: String,
    lines: &'a Lines,
}

impl<'a, 'i> Part<'a, 'i> {
    fn position(&self) -> Position {
        self.lines.position(self.node.range().start)
    }

    fn error(&self, fault: Fault) -> Error {
        Error::new(self.position(), fault)
    }

    /// The only element with this name.
    fn child(&self, element: &'static str) -> Result<Option<Part<'a, 'i>>, Error> {
        let mut found = self.node.children().filter(|node| node.has_tag_name(element));
        let part = found.next().map(|node| Part { node, of: self.of.clone(), lines: self.lines });
        match found.next() {
            Some(node) => {
                let fault = Fault::Repeated { of: self.of.clone(), element };
                Err(Error::new(self.lines.position(node.range().start), fault))
            }
            None => Ok(part),
        }
    }

    fn needed(&self, element: &'static str) -> Result<Part<'a, 'i>, Error> {
        self.child(element)?.ok_or_else(|| self.error(Fault::MissingElement { of: self.of.clone(), element }))
    }

    fn attribute(&self, attribute: &'static str) -> Result<&'a str, Error> {
        let element = || short(self.node.tag_name().name());
        let missing = || self.error(Fault::MissingAttribute { of: self.of.clone(), element: element(), attribute });
        self.node.attribute(attribute).ok_or_else(missing)
    }

    /// Numbers separated by spaces.
    fn numbers<const N: usize>(&self, attribute: &'static str) -> Result<[f64; N], Error> {
        let text = self.attribute(attribute)?;
        let numbers = text.split_ascii_whitespace().map(|number| number.parse().ok().filter(|x: &f64| x.is_finite()));
        let numbers: Option<Vec<f64>> = numbers.take(N + 1).collect();
        let wrong = || Fault::NotNumbers { of: self.of.clone(), attribute, text: short(text), expected: N };
        numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| self.error(wrong()))
    }

    fn number(&self, attribute: &'static str) -> Result<f64, Error> {
        self.numbers(attribute).map(|[x]| x)
    }

    /// A number, if the attribute exists.
    fn optional(&self, attribute: &'static str) -> Result<Option<f64>, Error> {
        self.node.attribute(attribute).map(|_| self.number(attribute)).transpose()
    }

    /// The element `origin`; zero if it or one of its attributes does not exist.
    fn origin(&self) -> Result<Pose, Error> {
        let Some(origin) = self.child("origin")? else { return Ok(Pose::default()) };
        let vector = |attribute| match origin.node.has_attribute(attribute) {
            true => origin.numbers(attribute),
            false => Ok([0.0; 3]),
        };
        Ok(Pose { xyz: vector("xyz")?, rpy: vector("rpy")? })
    }

    fn inertial(&self) -> Result<Inertial, Error> {
        let inertia = self.needed("inertia")?;
        let mut tensor = [0.0; 6];
        for (entry, attribute) in tensor.iter_mut().zip(["ixx", "iyy", "izz", "ixy", "ixz", "iyz"]) {
            *entry = inertia.number(attribute)?;
        }
        Ok(Inertial { mass: self.needed("mass")?.number("value")?, origin: self.origin()?, tensor })
    }

    fn joint(&self, name: String) -> Result<Joint, Error> {
        let kind = match self.attribute("type")? {
            "revolute" => Kind::Revolute,
            "continuous" => Kind::Continuous,
            "prismatic" => Kind::Prismatic,
            "fixed" => Kind::Fixed,
            "floating" => Kind::Floating,
            "planar" => Kind::Planar,
            other => return Err(self.error(Fault::UnknownType { joint: name, found: short(other) })),
        };
        let link = |element| Ok::<_, Error>(self.needed(element)?.attribute("link")?.to_string());
        let (parent, child) = (link("parent")?, link("child")?);
        let axis = self.child("axis")?.map_or(Ok([1.0, 0.0, 0.0]), |axis| axis.numbers("xyz"))?;
        let dynamics = self.child("dynamics")?;
        let of_dynamics = |attribute| dynamics.as_ref().map_or(Ok(None), |dynamics| dynamics.optional(attribute));
        Ok(Joint {
            name,
            kind,
            parent,
            child,
            origin: self.origin()?,
            axis,
            limit: self.child("limit")?.map(|limit| limit.limit()).transpose()?,
            damping: of_dynamics("damping")?.unwrap_or(0.0),
            friction: of_dynamics("friction")?.unwrap_or(0.0),
            mimic: self.child("mimic")?.map(|mimic| mimic.mimic()).transpose()?,
            at: self.position(),
        })
    }

    fn limit(&self) -> Result<Limit, Error> {
        let of = |attribute| self.optional(attribute);
        let (lower, upper) = (of("lower")?.unwrap_or(0.0), of("upper")?.unwrap_or(0.0));
        Ok(Limit { lower, upper, effort: of("effort")?, velocity: of("velocity")? })
    }

    fn mimic(&self) -> Result<Mimic, Error> {
        let joint = self.attribute("joint")?.to_string();
        let (multiplier, offset) = (self.optional("multiplier")?.unwrap_or(1.0), self.optional("offset")?.unwrap_or(0.0));
        Ok(Mimic { joint, multiplier, offset })
    }
}
