//! Bounds on the size of a text, checked before it is parsed.
//!
//! The parser compares every attribute of an element, and every namespace, with all others, so their numbers are bounded too.

use crate::error::{Error, Fault, Position};

/// Largest size of a file.
pub(crate) const MAX_BYTES: usize = 16 << 20;
/// Largest number of elements, texts and comments.
pub(crate) const MAX_NODES: u32 = 1 << 20;
/// Largest number of links.
pub(crate) const MAX_LINKS: usize = 10_000;
/// Largest number of `=` in a tag.
const MAX_ATTRIBUTES: usize = 256;
/// Largest number of `xmlns` in a text.
const MAX_NAMESPACES: usize = 64;

/// # Errors
/// A text that is too large, or a document type definition.
pub(crate) fn check(text: &str) -> Result<(), Error> {
    let bound = |what, found: usize, limit: usize, at: usize| match found > limit {
        true => Err(Error::new(Lines::new(text).position(at), Fault::TooLarge { what, found, limit })),
        false => Ok(()),
    };
    if text.len() > MAX_BYTES {
        return Err(Error::without_position(Fault::TooLarge { what: "bytes", found: text.len(), limit: MAX_BYTES }));
    }
    let namespaces = text.match_indices("xmlns").map(|(at, _)| at);
    bound("namespaces", namespaces.clone().count(), MAX_NAMESPACES, namespaces.last().unwrap_or(0))?;
    let mut rest = 0;
    while let Some(start) = text[rest..].find('<').map(|at| rest + at) {
        if text[start..].starts_with("<!DOCTYPE") {
            return Err(Error::new(Lines::new(text).position(start), Fault::DocumentType));
        }
        rest = match text[start..].starts_with("<!--") {
            true => text[start..].find("-->").map_or(text.len(), |end| start + end),
            false => {
                let end = text[start + 1..].find('<').map_or(text.len(), |end| start + 1 + end);
                bound("attributes in one element", text[start..end].matches('=').count(), MAX_ATTRIBUTES, start)?;
                end
            }
        };
    }
    Ok(())
}

/// The beginnings of the lines of a text.
pub(crate) struct Lines(Vec<usize>);

impl Lines {
    pub(crate) fn new(text: &str) -> Self {
        Lines([0].into_iter().chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    pub(crate) fn position(&self, at: usize) -> Position {
        let line = self.0.partition_point(|start| *start <= at);
        Position { line, column: at + 1 - self.0[line.saturating_sub(1)] }
    }
}
