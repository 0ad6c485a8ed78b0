//! Results of a check, for machines (the fields; `serde` with that feature) and for people (`Display`).

use std::fmt;

use crate::Error;

/// The verdict on one block, or on all blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Verdict {
    /// Equal to the references within the tolerance, at every point.
    Right,
    /// Right at every point, but the points do not cover all branches or features of the formula; a note lists those not covered.
    Undecided,
    /// Different from the value on which all references agree.
    Wrong,
    /// The references disagree: examine the formula itself first.
    ReferencesDisagree,
    /// Nothing was compared; this is not a success.
    #[default]
    NothingCompared,
    /// The check could not be run; the report's `refused` gives the reason.
    Refused,
}

/// Kind of mistake that explains a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Mistake {
    /// −1 times the true value.
    SignFlipped,
    /// The transpose of the true value.
    Transposed,
    /// A constant times the true value.
    Factor,
    /// A named term is absent.
    TermMissing,
    /// A named term occurs twice, or has the wrong sign or factor.
    TermWrong,
    /// The true value of other arguments: another node, another coordinate, sine for cosine.
    OtherArgument,
    /// The true value of another block.
    OtherBlock,
    /// Two rows or columns are exchanged.
    Swapped,
    /// Zero, although the true value is not zero.
    Zero,
    /// Not zero, although the true value is zero.
    NotZero,
    /// Wrong on one side of a threshold only.
    OneSided,
    /// Right in the leading digits only.
    FewDigits,
    /// The wrong numbers of rows and columns.
    Shape,
    /// Infinite or NaN.
    NotFinite,
    /// No simple explanation.
    Unexplained,
}

/// The likely mistake that causes a difference.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Diagnosis {
    /// The kind of mistake.
    pub mistake: Mistake,
    /// Description of the mistake.
    pub text: String,
}

impl Diagnosis {
    pub(super) fn new(mistake: Mistake, text: String) -> Self {
        Diagnosis { mistake, text }
    }
}

/// A wrong entry of a block, with the names of its equation and its variable.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Entry {
    /// The differentiated quantity.
    pub row: String,
    /// The variable of the derivative.
    pub column: String,
    /// The user's value.
    pub hand: f64,
    /// The value on which the references agree.
    pub truth: f64,
    /// The largest allowed difference.
    pub allowed: f64,
    /// Index of the point where the difference is largest, counted from 0; the points of the check come first, then the additional points
    /// found for features of the formula that those do not show.
    pub point: usize,
    /// Values of the arguments on which the entry depends at this point, with their names.
    pub at: Vec<(String, f64)>,
}

/// The comparison of one block.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BlockReport {
    /// Name of the block.
    pub name: String,
    /// Numbers of rows and columns.
    pub size: (usize, usize),
    /// Number of points compared.
    pub points: usize,
    /// Number of additional points at which the block was compared; they were computed because they show features of the formula that the
    /// other points do not.
    pub bends: usize,
    /// Number of points set aside because the references disagree.
    pub set_aside: usize,
    /// The outcome.
    pub verdict: Verdict,
    /// The largest |hand − true|.
    pub absolute_error: f64,
    /// The largest |hand − true| relative to the size of its row and column.
    pub relative_error: f64,
    /// Tolerance of the check, relative to the sizes of row and column, without rounding.
    pub tolerance: f64,
    /// The allowed relative error, including rounding, of the entry whose error is closest to its allowed value or exceeds it most.
    pub allowed: f64,
    /// The largest relative difference between dual numbers and complex step.
    pub complex_step_error: f64,
    /// The largest relative difference between dual numbers and differences.
    pub differences_error: f64,
    /// Number of entries that are wrong at some point.
    pub wrong_entries: usize,
    /// The entries with the largest errors.
    pub entries: Vec<Entry>,
    /// The likely mistakes; several if rows have different mistakes.
    pub diagnoses: Vec<Diagnosis>,
    /// Further observations.
    pub notes: Vec<String>,
}

/// The comparison of all given blocks.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Report {
    /// Name of the checked object.
    pub title: String,
    /// One report for each block, in the order given.
    pub blocks: Vec<BlockReport>,
    /// Observations that concern all blocks.
    pub notes: Vec<String>,
    /// Reason why the check was not run, for example a tolerance that no error can exceed, or no point at which the formula is defined.
    #[cfg_attr(feature = "serde", serde(serialize_with = "as_text"))]
    pub refused: Option<Error>,
}

#[cfg(feature = "serde")]
fn as_text<S: serde::Serializer>(error: &Option<Error>, serializer: S) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&error.as_ref().map(Error::to_string), serializer)
}

impl Report {
    /// The overall verdict: right if at least one block was compared and all are right.
    pub fn verdict(&self) -> Verdict {
        if self.refused.is_some() { Verdict::Refused } else { Verdict::of_all(&self.blocks) }
    }

    /// The report of the block called `name`.
    pub fn block(&self, name: &str) -> Option<&BlockReport> {
        self.blocks.iter().find(|block| block.name == name)
    }
}

/// Methods that follow from the verdict of a report.
macro_rules! outcome {
    ($report:ty) => {
        impl $report {
            /// True if everything is right.
            pub fn passed(&self) -> bool {
                self.verdict() == Verdict::Right
            }

            /// Asserts in a test that everything is right.
            ///
            /// # Panics
            /// If not everything is right; the message is the whole report.
            #[track_caller]
            pub fn assert_passed(&self) {
                assert!(self.passed(), "\n{self}");
            }
        }
    };
}

pub(super) use outcome;

outcome!(Report);

impl Verdict {
    /// The worst verdict of the blocks; `NothingCompared` if there are none.
    fn of_all(blocks: &[BlockReport]) -> Verdict {
        let worst =
            [Verdict::Wrong, Verdict::ReferencesDisagree, Verdict::NothingCompared, Verdict::Undecided, Verdict::Right];
        let any = |verdict: &Verdict| blocks.iter().any(|block| block.verdict == *verdict);
        worst.into_iter().find(any).unwrap_or_default()
    }

    /// The library's verdict or, if that is right, the verdict of the user's blocks.
    pub(super) fn with(self, own: &[BlockReport]) -> Verdict {
        if self == Verdict::Right && !own.is_empty() { Verdict::of_all(own) } else { self }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Verdict::Right => "right",
            Verdict::Undecided => "undecided",
            Verdict::Wrong => "WRONG",
            Verdict::ReferencesDisagree => "references disagree",
            Verdict::NothingCompared => "nothing compared",
            Verdict::Refused => "refused",
        })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Some(error) = &self.refused {
            return writeln!(f, "{}: REFUSED: {error}", self.title);
        }
        let wrong = self.blocks.iter().filter(|block| block.verdict == Verdict::Wrong).count();
        let summary = match self.verdict() {
            Verdict::Right if self.blocks.len() == 1 => "right".to_string(),
            Verdict::Right => format!("all {} blocks are right", self.blocks.len()),
            Verdict::Wrong => format!("{wrong} of {} blocks wrong", self.blocks.len()),
            Verdict::ReferencesDisagree => "the references disagree; see below".to_string(),
            Verdict::Undecided => "undecided: right where it was compared, but see the notes".to_string(),
            Verdict::NothingCompared | Verdict::Refused => "FAILED, because nothing was compared".to_string(),
        };
        writeln!(f, "{}: {summary}", self.title)?;
        if self.blocks.is_empty() {
            return writeln!(f, "  provide at least one matrix and at least one point");
        }
        let width = self.blocks.iter().map(|block| block.name.chars().count()).max().unwrap_or(0).max(5);
        writeln!(
            f,
            "  {:width$}  {:>7}  {:>6}  {:>9}  {:>9}  {:>9}  verdict",
            "block", "size", "points", "abs. err.", "rel. err.", "tolerance"
        )?;
        for block in &self.blocks {
            let size = format!("{}×{}", block.size.0, block.size.1);
            let error = |x: f64| if x == 0.0 { "0".to_string() } else { format!("{x:.1e}") };
            let (name, points, verdict) = (&block.name, block.points, block.verdict);
            let [abs, rel, allowed] = [block.absolute_error, block.relative_error, block.allowed].map(error);
            writeln!(f, "  {name:width$}  {size:>7}  {points:>6}  {abs:>9}  {rel:>9}  {allowed:>9}  {verdict}")?;
        }
        for block in self.blocks.iter().filter(|block| block.verdict != Verdict::Right || !block.notes.is_empty()) {
            write!(f, "{block}")?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "\n{note}"))
    }
}

impl fmt::Display for BlockReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "\n{}: {}", self.name, self.verdict)?;
        for diagnosis in &self.diagnoses {
            writeln!(f, "  → {}", diagnosis.text)?;
        }
        for entry in &self.entries {
            let Entry { row, column, hand, truth, allowed, point, at } = entry;
            let what = if column.is_empty() { row.clone() } else { format!("d({row})/d({column})") };
            writeln!(f, "  {what} = {hand:>+.9e} by hand, {truth:>+.9e} is true, ± {allowed:.0e} allowed")?;
            if !at.is_empty() {
                let at: Vec<String> = at.iter().map(|(name, x)| format!("{name} = {x:.9}")).collect();
                writeln!(f, "    at point {point}: {}", at.join(", "))?;
            }
        }
        let more = self.wrong_entries.saturating_sub(self.entries.len());
        if more > 0 && !self.entries.is_empty() {
            writeln!(f, "  and {more} more entries")?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "  note: {note}"))
    }
}
