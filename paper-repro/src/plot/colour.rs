//! The colours of Okabe and Ito, told apart by colour-blind readers, and greys.

use plotters::style::RGBColor;

/// A red, green and blue triple.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    /// Black, of text and frames.
    pub const BLACK: Self = Self(0, 0, 0);
    /// Blue.
    pub const BLUE: Self = Self(0, 114, 178);
    /// Vermilion, the red of the palette.
    pub const RED: Self = Self(213, 94, 0);
    /// Bluish green.
    pub const GREEN: Self = Self(0, 158, 115);
    /// Reddish purple.
    pub const PURPLE: Self = Self(204, 121, 167);
    /// Orange.
    pub const ORANGE: Self = Self(230, 159, 0);
    /// Sky blue.
    pub const SKY: Self = Self(86, 180, 233);
    /// Mid grey, of what stands behind.
    pub const GREY: Self = Self(150, 150, 150);
    /// Light grey, of grids.
    pub const LIGHT: Self = Self(228, 228, 228);
    /// White, of the page.
    pub const WHITE: Self = Self(255, 255, 255);

    /// The colour of the `index`-th series, repeating after the seventh.
    pub fn nth(index: usize) -> Self {
        const CYCLE: [Colour; 7] =
            [Colour::BLUE, Colour::RED, Colour::GREEN, Colour::PURPLE, Colour::ORANGE, Colour::SKY, Colour::BLACK];
        CYCLE[index % CYCLE.len()]
    }
}

impl From<Colour> for RGBColor {
    fn from(Colour(red, green, blue): Colour) -> Self {
        Self(red, green, blue)
    }
}
