//! The figures of the paper; each draws its files and returns what it has to say beside the paper.

pub mod fig1;
pub mod fig2;
pub mod fig3;
pub mod fig4;
pub mod fig5;
pub mod fig6;
mod mechanism;

/// Names the files in the error, if there is one.
pub fn saved(result: Result<(), crate::plot::PlotError>, stem: &std::path::Path) -> Result<(), crate::error::Error> {
    result.map_err(|source| crate::error::Error::Figure { stem: stem.to_owned(), source })
}
