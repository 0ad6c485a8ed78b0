//! Figures of the report: each is drawn to `<stem>.svg` and `<stem>.png`, its data written to `<stem>.csv`.

mod chart;
mod csv;
mod page;
mod ruler;
mod scene;

pub use chart::{Chart, Panels, Series, Style};
pub use plotters::chart::SeriesLabelPosition as Place;
pub use plotters::style::RGBColor as Colour;
pub use ruler::Axis;
pub use scene::{Scene, SceneChart, Shape};

/// A small number in one digit, as it is set in print: 10⁻⁴.
pub fn scientific(value: f64) -> String {
    ruler::scientific(&format!("{value:.0e}"))
}

/// A point of the data, x to the right and y up.
pub type Point = (f64, f64);

/// The colours of Okabe and Ito, told apart by colour-blind readers, and a grey for what stands behind.
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
                Panels { charts: vec![chart; 3], columns: 2 }.save(&stem).unwrap();
                assert!(read(&stem, "png").starts_with(b"\x89PNG"));
            }
        }
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }

    #[test]
    fn scenes_are_written_with_their_words() {
        let stem = stem("scene");
        let link = Shape::line(vec![(0.0, 0.0), (9.0, 9.0)], colour::RED, 2.0);
        let disc = Shape::disc((1e6, 0.0), 1.0, colour::BLUE);
        let arrow = Shape::arrow((0.0, 0.0), (0.0, 0.0), colour::RED, "F(t)");
        let scene = Scene { title: "t = 0 s".to_owned(), shapes: vec![link, disc, arrow] };
        let chart =
            SceneChart { labels: Some(["x [m]", "y [m]"]), scenes: vec![scene; 3], columns: 2, ..SceneChart::default() };
        chart.save(&stem).unwrap();
        let svg = String::from_utf8(read(&stem, "svg")).unwrap();
        assert!(["t = 0 s", "F(t)", "x [m]"].iter().all(|words| svg.contains(words)));
        SceneChart::default().save(&stem).unwrap();
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }

    #[test]
    fn text_is_drawn_without_the_fonts_of_the_system() {
        let stem = stem("text");
        let dark = |words: &str| {
            let scenes = vec![Scene { title: words.to_owned(), shapes: Vec::new() }];
            SceneChart { scenes, ..SceneChart::default() }.save(&stem).unwrap();
            read(&stem, "png").len()
        };
        assert!(dark("‖Φ‖∞ ≤ φ₁") > dark("") + 500);
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }
}
