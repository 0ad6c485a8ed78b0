//! [`AccelerationsOfCosts`]: v̇ and λ for costs.

use super::Accelerations;
use crate::system::Depends;
use crate::{Error, System};

/// v̇ and λ for costs; the workspace is created at the first cost that may need them.
#[derive(Default)]
pub(crate) struct AccelerationsOfCosts {
    pub(crate) own: Option<Box<Accelerations>>,
    /// The error because of which they are missing, if the costs may not need them.
    pub(crate) missing: Option<Error>,
    /// True if programs compute their derivatives on lifted numbers, false for the plain formulas.
    pub(crate) by_programs: bool,
}

impl AccelerationsOfCosts {
    /// Result of `find` for a state; `None` if it fails but may not be needed. If it is needed, the value of the cost becomes NaN.
    pub(crate) fn find<T>(
        &mut self,
        system: &System,
        uses: Depends,
        find: impl FnOnce(&mut Accelerations) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        let own = self.own.get_or_insert_with(|| Box::new(Accelerations::new(system)));
        match find(own) {
            Ok(found) => Ok(Some(found)),
            Err(error) if uses == Depends::Perhaps => {
                own.forget();
                self.missing = Some(error);
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}
