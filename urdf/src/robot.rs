//! [`Robot`]: the links and joints of a file.

use std::path::Path;

use nalgebra::{Rotation3, Vector3};

use crate::error::{Error, Fault, Position};
use crate::tree::Tree;
use crate::{read, scan};

/// The links and joints of a URDF file. Names refer to each other; [`add_to`](Robot::add_to) checks them again, so all fields may be changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Robot {
    /// The name of the robot.
    pub name: String,
    /// The links in the order of the file.
    pub links: Vec<Link>,
    /// The joints in the order of the file.
    pub joints: Vec<Joint>,
}

/// A rigid body, or a frame without mass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Link {
    /// The name of the link.
    pub name: String,
    /// Mass, centre and inertia; `None` for a frame without mass.
    pub inertial: Option<Inertial>,
    /// The place in the file.
    pub at: Position,
}

/// Mass, centre of mass and inertia of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertial {
    /// The mass, kg; 0 for a frame.
    pub mass: f64,
    /// The centre of mass and the axes of the inertia tensor in the frame of the link.
    pub origin: Pose,
    /// J_xx, J_yy, J_zz, J_xy, J_xz, J_yz about the centre of mass, kg m².
    pub tensor: [f64; 6],
}

/// A point and axes in another frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// The point, m.
    pub xyz: [f64; 3],
    /// Roll, pitch and yaw, rad: R = R_z(yaw) R_y(pitch) R_x(roll).
    pub rpy: [f64; 3],
}

/// A joint from a parent link to a child link.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// The name of the joint.
    pub name: String,
    /// The relative motions that it admits.
    pub kind: Kind,
    /// The name of the outer link.
    pub parent: String,
    /// The name of the link that the joint carries.
    pub child: String,
    /// The frame of the child in the frame of the parent where all coordinates are zero.
    pub origin: Pose,
    /// The axis in the frame of the child, of any positive length; the normal of the plane for a planar joint.
    pub axis: [f64; 3],
    /// The limits of the coordinate, velocity and effort; they have no effect on the motion.
    pub limit: Option<Limit>,
    /// The viscous damping, N m s/rad or N s/m.
    pub damping: f64,
    /// The friction, N m or N; it has no effect on the motion.
    pub friction: f64,
    /// The joint that this one follows.
    pub mimic: Option<Mimic>,
    /// The place in the file.
    pub at: Position,
}

/// The type of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A hinge with limits.
    Revolute,
    /// A hinge without limits.
    Continuous,
    /// A slider.
    Prismatic,
    /// No relative motion.
    Fixed,
    /// Every relative motion.
    Floating,
    /// Two displacements perpendicular to the axis, and a rotation about it.
    Planar,
}

/// Limits of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limit {
    /// The least value of the coordinate, rad or m.
    pub lower: f64,
    /// The largest value of the coordinate, rad or m.
    pub upper: f64,
    /// The largest torque or force, N m or N.
    pub effort: Option<f64>,
    /// The largest velocity, rad/s or m/s.
    pub velocity: Option<f64>,
}

/// The value of a joint is a multiple of the value of another one plus an offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// The name of the other joint.
    pub joint: String,
    /// The factor.
    pub multiplier: f64,
    /// The offset, rad or m.
    pub offset: f64,
}

impl Kind {
    /// True for joints with a single coordinate.
    pub fn has_one_coordinate(self) -> bool {
        matches!(self, Kind::Revolute | Kind::Continuous | Kind::Prismatic)
    }
}

impl Pose {
    pub(crate) fn rotation(&self) -> Rotation3<f64> {
        let [roll, pitch, yaw] = self.rpy;
        Rotation3::from_euler_angles(roll, pitch, yaw)
    }

    pub(crate) fn point(&self) -> Vector3<f64> {
        Vector3::from(self.xyz)
    }
}

impl Robot {
    /// Reads a robot from the text of a URDF file.
    ///
    /// # Errors
    /// A text that is too large, not well-formed or no URDF; numbers that are missing or not finite; links and joints that do not form a tree.
    pub fn from_text(text: &str) -> Result<Self, Error> {
        scan::check(text)?;
        let robot = read::robot(text)?;
        Tree::new(&robot)?;
        Ok(robot)
    }

    /// Reads a robot from a URDF file.
    ///
    /// # Errors
    /// A file that cannot be read, and the errors of [`from_text`](Self::from_text).
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        use std::io::Read;
        let path = path.as_ref();
        let unreadable = |error: std::io::Error| {
            Error::without_position(Fault::Unreadable { path: path.to_path_buf(), reason: error.to_string() })
        };
        let file = std::fs::File::open(path).map_err(unreadable)?;
        let mut bytes = Vec::new();
        file.take(scan::MAX_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        let text = String::from_utf8(bytes);
        let text = text.map_err(|error| unreadable(std::io::Error::new(std::io::ErrorKind::InvalidData, error)))?;
        Self::from_text(&text)
    }
}
