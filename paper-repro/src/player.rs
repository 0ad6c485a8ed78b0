//! Animation of the motion under the identified force.

use std::path::Path;

use hamiltonian_adjoint::Animation;

use crate::error::Error;
use crate::experiment::Experiment;
use crate::files;

pub fn write(experiment: &Experiment, folder: &Path) -> Result<(), Error> {
    let (system, optimum) = (&experiment.system, experiment.optimum()?);
    let degrees: Vec<Vec<f64>> = Vec::from_iter(
        (5..system.n()).step_by(3).map(|angle| optimum.motion.q.row(angle).iter().map(|phi| phi.to_degrees()).collect()),
    );
    let mut animation =
        Animation::new(system, &optimum.inputs, &optimum.motion)?.title("Swing-up of the links by the force on the cart");
    for (link, degrees) in degrees.iter().enumerate() {
        animation = animation.plot(&format!("angle of link {}", link + 1), "°", degrees)?;
    }
    files::write(&folder.join("swing-up.html"), animation.html())?;
    files::write(&folder.join("swing-up.svg"), animation.animated_svg())
}
