//! Errors with the line, the column and the name of what is wrong.

use std::fmt;
use std::path::PathBuf;

/// A place in a file, counted from 1; 0 for parts that were not read from a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Position {
    /// The line.
    pub line: usize,
    /// The column, in bytes.
    pub column: usize,
}

/// A fault and its place.
#[derive(Clone, PartialEq)]
pub struct Error {
    /// The place; line 0 if there is none.
    pub at: Position,
    /// What is wrong.
    pub fault: Fault,
}

/// The reason why a robot was refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// The file cannot be read.
    Unreadable {
        /// The path.
        path: PathBuf,
        /// The message of the operating system.
        reason: String,
    },
    /// The file has more of something than is accepted.
    TooLarge {
        /// What was counted.
        what: &'static str,
        /// The number found, or the first one that is too large.
        found: usize,
        /// The largest number that is accepted.
        limit: usize,
    },
    /// The text is not well-formed XML.
    Xml {
        /// The message of the parser.
        reason: String,
    },
    /// The text has a document type definition.
    DocumentType,
    /// The text is a xacro file, which `xacro` turns into a URDF file.
    Xacro {
        /// The element.
        element: String,
    },
    /// The outermost element is not `robot`.
    NotRobot {
        /// The element that was found.
        found: String,
    },
    /// An element lacks an attribute.
    MissingAttribute {
        /// The part of the robot: `link 'arm'`.
        of: String,
        /// The element.
        element: String,
        /// The attribute.
        attribute: &'static str,
    },
    /// A part lacks an element.
    MissingElement {
        /// The part of the robot.
        of: String,
        /// The element.
        element: &'static str,
    },
    /// A part has an element twice.
    Repeated {
        /// The part of the robot.
        of: String,
        /// The element.
        element: &'static str,
    },
    /// An attribute is not a finite number, or not as many as needed.
    NotNumbers {
        /// The part of the robot.
        of: String,
        /// The attribute.
        attribute: &'static str,
        /// Its text, of which at most the first 40 characters.
        text: String,
        /// The number of numbers needed.
        expected: usize,
    },
    /// A joint has an unknown type.
    UnknownType {
        /// The joint.
        joint: String,
        /// The type.
        found: String,
    },
    /// Two links or two joints have the same name.
    DuplicateName {
        /// The kind: link, joint.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A joint refers to a link that does not exist.
    UnknownLink {
        /// The joint.
        joint: String,
        /// The role of the link: parent, child.
        role: &'static str,
        /// The link.
        link: String,
    },
    /// Two joints carry the same link.
    SecondParent {
        /// The later joint.
        joint: String,
        /// The earlier joint.
        first: String,
        /// The link.
        link: String,
    },
    /// Joints carry links in a loop.
    Loop {
        /// One of these links.
        link: String,
    },
    /// Several links are carried by no joint.
    SeveralRoots {
        /// The first two.
        links: [String; 2],
    },
    /// The robot has no links.
    NoLinks,
    /// The axis of a joint has no direction.
    Axis {
        /// The joint.
        joint: String,
        /// The axis.
        axis: [f64; 3],
    },
    /// A value is out of range.
    Value {
        /// The part of the robot.
        of: String,
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: f64,
        /// The condition on the value.
        must_be: &'static str,
    },
    /// No distribution of mass has the inertia of a link.
    Inertia {
        /// The link.
        link: String,
        /// The reason.
        doubt: Doubt,
    },
    /// A joint cannot follow another one.
    Mimic {
        /// The joint.
        joint: String,
        /// The joint that it should follow.
        of: String,
        /// The reason.
        why: Why,
    },
    /// A joint that should be locked does not exist.
    UnknownLock {
        /// The name.
        joint: String,
    },
    /// A joint with several coordinates should be locked at a value other than zero.
    Lock {
        /// The joint.
        joint: String,
        /// The value.
        value: f64,
    },
}

/// The reason why a joint cannot follow another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// The other joint does not exist.
    Unknown,
    /// The joints follow each other in a circle.
    Circle,
    /// One of the two has several coordinates.
    Coordinates,
}

/// The reason why no distribution of mass has an inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// Moments of inertia without a mass.
    NoMass,
    /// One of the principal moments is negative, or larger than the sum of the other two.
    Moments {
        /// The principal moments about the centre of mass, kg m², in ascending order; not finite if they cannot be computed.
        moments: [f64; 3],
    },
}

impl Error {
    pub(crate) fn new(at: Position, fault: Fault) -> Self {
        Error { at, fault }
    }

    pub(crate) fn without_position(fault: Fault) -> Self {
        Error { at: Position::default(), fault }
    }
}

impl std::error::Error for Error {}

/// `Debug` prints the message of `Display`, because `expect`, and a `main` that returns the error, print `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.at.line > 0 {
            write!(f, "line {}, column {}: ", self.at.line, self.at.column)?;
        }
        write!(f, "{}", self.fault)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Unreadable { path, reason } => write!(f, "`{}` cannot be read: {reason}", path.display()),
            Fault::TooLarge { what, found, limit } => write!(f, "the file has {found} {what}; at most {limit} are accepted"),
            Fault::Xml { reason } => write!(f, "the file is not well-formed XML: {reason}"),
            Fault::DocumentType => write!(f, "document type definitions are not accepted; remove the `<!DOCTYPE` part"),
            Fault::Xacro { element } => {
                write!(f, "`{element}` is a part of a xacro file; run `xacro FILE > robot.urdf` first")
            }
            Fault::NotRobot { found } => write!(f, "the outermost element is `{found}` instead of `robot`"),
            Fault::MissingAttribute { of, element, attribute } => {
                write!(f, "the element `{element}` of {of} has no attribute `{attribute}`")
            }
            Fault::MissingElement { of, element } => write!(f, "{of} has no element `{element}`"),
            Fault::Repeated { of, element } => write!(f, "{of} has two elements `{element}`; remove one"),
            Fault::NotNumbers { of, attribute, text, expected: 1 } => {
                write!(f, "the attribute `{attribute}` of {of} is '{text}' instead of a finite number")
            }
            Fault::NotNumbers { of, attribute, text, expected } => {
                write!(f, "the attribute `{attribute}` of {of} is '{text}' instead of {expected} finite numbers")
            }
            Fault::UnknownType { joint, found } => write!(
                f,
                "joint '{joint}' has the type '{found}' instead of revolute, continuous, prismatic, fixed, floating or planar"
            ),
            Fault::DuplicateName { kind, name } => write!(f, "two {kind}s have the name '{name}'"),
            Fault::UnknownLink { joint, role, link } => {
                write!(f, "the {role} of joint '{joint}' is the link '{link}', which does not exist")
            }
            Fault::SecondParent { joint, first, link } => {
                write!(
                    f,
                    "joint '{joint}' carries the link '{link}', which joint '{first}' carries already; loops are not supported"
                )
            }
            Fault::Loop { link } => {
                write!(f, "joints carry the link '{link}' in a loop; one link must be carried by no joint")
            }
            Fault::SeveralRoots { links: [first, second] } => {
                write!(f, "no joint carries the links '{first}' and '{second}'; connect them by a joint")
            }
            Fault::NoLinks => write!(f, "the robot has no links"),
            Fault::Axis { joint, axis } => write!(f, "the axis {axis:?} of joint '{joint}' has no direction"),
            Fault::Value { of, what, value, must_be } => write!(f, "the {what} of {of} is {value}; it must be {must_be}"),
            Fault::Inertia { link, doubt } => {
                match doubt {
                    Doubt::NoMass => write!(f, "link '{link}' has moments of inertia but no mass")?,
                    Doubt::Moments { moments: [a, b, c] } => write!(
                        f,
                        "the principal moments of inertia of link '{link}' are {a:.4e}, {b:.4e} and {c:.4e} kg m², of which one is negative or larger than \
                         the sum of the other two"
                    )?,
                }
                write!(f, "; correct them or set `Options::accept_impossible_inertias`")
            }
            Fault::Mimic { joint, of, why } => {
                let reason = match why {
                    Why::Unknown => "which does not exist",
                    Why::Circle => "which follows it in turn",
                    Why::Coordinates => "but one of them has several coordinates",
                };
                write!(f, "joint '{joint}' follows joint '{of}', {reason}; correct it or set `Options::ignore_mimic`")
            }
            Fault::UnknownLock { joint } => write!(f, "joint '{joint}' should be locked but does not exist"),
            Fault::Lock { joint, value } => {
                write!(f, "joint '{joint}' has several coordinates and can be locked at 0 only, not at {value}")
            }
        }
    }
}
