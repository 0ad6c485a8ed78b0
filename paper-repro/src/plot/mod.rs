//! Figures of the report: each is drawn to `<stem>.svg`, with the feature `png` also to `<stem>.png`, its data written to
//! `<stem>.csv` and its caption, if it has one, to `<stem>.txt`.

mod chart;
mod csv;
mod page;
#[cfg(feature = "png")]
mod png;
mod ruler;
mod series;

pub use chart::{Chart, Panels};
pub use plotters::chart::SeriesLabelPosition as Place;
pub use plotters::style::RGBColor as Colour;
pub use plotters::style::text_anchor::HPos as Side;
pub use ruler::Axis;
pub use series::{Series, Style};

/// A number with a typeset exponent: 1.6·10⁻⁴ for `1.6e-4`.
pub fn scientific(number: &str) -> String {
    ruler::scientific(number)
}

/// The caption of a figure: written to the SVG's description and to a text file, and drawn below the picture if it is shown.
#[derive(Clone, Debug, Default)]
pub struct Caption {
    pub text: String,
    pub shown: bool,
}

/// A point of the data, x to the right and y up.
pub type Point = (f64, f64);

/// The colours of Okabe and Ito, which colour-blind readers can distinguish, and a grey for the background.
pub mod colour {
    use super::Colour;

    pub const BLACK: Colour = Colour(0, 0, 0);
    pub const BLUE: Colour = Colour(0, 114, 178);
    /// Vermilion.
    pub const RED: Colour = Colour(213, 94, 0);
    pub const GREEN: Colour = Colour(0, 158, 115);
    pub const PURPLE: Colour = Colour(204, 121, 167);
    pub const ORANGE: Colour = Colour(230, 159, 0);
    pub const SKY: Colour = Colour(86, 180, 233);
    pub const GREY: Colour = Colour(150, 150, 150);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

    /// A stem in a folder of its own.
    fn stem(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("paper-repro-{name}-{}", std::process::id()));
        crate::files::folder(Some(&folder)).unwrap().join("figure.1")
    }

    fn read(stem: &Path, extension: &str) -> Vec<u8> {
        std::fs::read(stem.with_added_extension(extension)).unwrap()
    }

    #[test]
    fn charts_are_written_whatever_the_data() {
        let stem = stem("wild");
        let wild = vec![(0.0, f64::NAN), (1.0, -1e300), (2.0, 0.0), (f64::INFINITY, 1.0), (3.0, 1e300)];
        for points in [vec![], vec![(0.0, 0.0)], wild] {
            let series = |name: &str, style| Series::new(name, points.clone(), colour::RED, style);
            for y in [Axis::default(), Axis::log("‖Φ‖ [m]", 1e-16)] {
                let series = vec![series("a < b", Style::LineAndCircles), series("dashed", Style::Dashed)];
                let chart = Chart { y, series, ..Chart::default() };
                Panels::new(vec![chart; 3], 2).save(&stem).unwrap();
                assert!(read(&stem, "svg").starts_with(b"<svg"));
                #[cfg(feature = "png")]
                assert!(read(&stem, "png").starts_with(b"\x89PNG"));
            }
        }
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }

    #[test]
    fn sketches_are_written_with_their_words() {
        let stem = stem("sketch");
        let shape = |points: &[Point], style| Series::shape("shape", points.to_vec(), colour::RED, style, 1.0);
        let link = shape(&[(0.0, 0.0), (9.0, 9.0)], Style::Line);
        let far = shape(&[(1e6, 0.0), (1e6, 1.0), (0.0, 0.0)], Style::Filled);
        let arrow = shape(&[(0.0, 0.0), (0.0, 0.0)], Style::Arrow(2)).noted("F(t)", (0.0, 0.0), (0.0, 9.0), Side::Center);
        let ground = shape(&[(0.0, 0.0), (9.0, 0.0)], Style::Hatched);
        let series = vec![link, far, arrow, ground];
        let (title, x, y) = ("t = 0 s".to_owned(), Axis::linear("x [m]"), Axis::linear("y [m]"));
        let chart = Chart { title, x, y, series, ..Chart::default() };
        Panels::new(vec![chart; 3], 2).save_shapes(&stem).unwrap();
        let svg = String::from_utf8(read(&stem, "svg")).unwrap();
        assert!(["t = 0 s", "F(t)", "x [m]"].iter().all(|words| svg.contains(words)));
        assert!(String::from_utf8(read(&stem, "csv")).unwrap().contains("\nt = 0 s,1,shape,9.0,9.0\n"));
        Panels::new(Vec::new(), 1).save_shapes(&stem).unwrap();
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }

    #[test]
    fn both_axes_of_what_is_to_scale_have_one() {
        let axis = |range| Axis { range: Some(range), ..Axis::default() };
        let chart =
            Chart { x: axis((-1.0, 3.0)), y: axis((0.0, 2.0)), framed: false, ..Chart::default() }.equally_scaled(422.0);
        // The margins of the frame are 22 and 14 points.
        assert_eq!(chart.size, (422.0, 214.0));
    }

    #[test]
    fn captions_are_the_description_and_are_drawn_where_asked() {
        let stem = stem("caption");
        let text = "Fig. 1: a < b & c.\nAssumed: nothing.".to_owned();
        let heights = [false, true].map(|shown| {
            let caption = Caption { text: text.clone(), shown };
            Chart { caption, ..Chart::default() }.save(&stem).unwrap();
            assert_eq!(read(&stem, "txt"), format!("{text}\n").into_bytes());
            let svg = String::from_utf8(read(&stem, "svg")).unwrap();
            assert!(svg.contains(
                "<title>Fig. 1: a &lt; b &amp; c.</title>\n<desc>Fig. 1: a &lt; b &amp; c.\nAssumed: nothing.</desc>"
            ));
            assert_eq!(svg.matches("Assumed").count(), if shown { 2 } else { 1 });
            svg.split('"').nth(3).unwrap().parse::<f64>().unwrap()
        });
        assert_eq!(heights, [450.0, 494.0]);
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }

    #[test]
    fn panels_have_one_legend_if_it_is_the_same() {
        let stem = stem("legend");
        let chart = |names: [&str; 2]| {
            let series = names.map(|name| Series::new(name, vec![(0.0, 0.0), (1.0, 1.0)], colour::RED, Style::Line));
            Chart { series: series.to_vec(), ..Chart::default() }
        };
        for (second, count) in [(["a1", "b1"], 1), (["a1", "c1"], 2)] {
            Panels::new(vec![chart(["a1", "b1"]), chart(second)], 2).save(&stem).unwrap();
            let svg = String::from_utf8(read(&stem, "svg")).unwrap();
            assert_eq!(svg.matches("\na1\n").count(), count, "{svg}");
        }
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }

    #[cfg(feature = "png")]
    #[test]
    fn text_is_drawn_without_the_fonts_of_the_system() {
        let stem = stem("text");
        let dark = |words: &str| {
            Chart { title: words.to_owned(), framed: false, ..Chart::default() }.save(&stem).unwrap();
            read(&stem, "png").len()
        };
        assert!(dark("‖Φ‖∞ ≤ φ₁") > dark("") + 500);
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }
}
