//! The figures of the paper; each draws its files and returns what it has to say beside the paper.

pub mod fig1;
pub mod fig2;
pub mod fig3;
pub mod fig4;
pub mod fig5;
pub mod fig6;
mod mechanism;
