//! Figures of the report: each is drawn to `<stem>.svg` and `<stem>.png`, its data written to `<stem>.csv`.

mod axis;
mod canvas;
mod colour;
mod csv;
mod fonts;
mod frame;
mod legend;
mod line_chart;
mod panels;
mod scene_chart;
mod shape;

pub use axis::{Axis, Scale};
pub use colour::Colour;
pub use legend::Legend;
pub use line_chart::{LineChart, Series, Style};
pub use panels::Panels;
pub use scene_chart::{Scene, SceneChart};
pub use shape::Shape;

/// A point of the data or of the page, x to the right; y is up in the data and down on the page.
pub type Point = (f64, f64);

use crate::error::Error;
use crate::files;
use canvas::Canvas;
use std::{ffi::OsString, path::Path, path::PathBuf};

/// Writes the drawing and its data to the three files of the stem.
fn save(stem: &Path, canvas: &Canvas, csv: &str) -> Result<(), Error> {
    files::write(&with_suffix(stem, ".csv"), csv)?;
    files::write(&with_suffix(stem, ".svg"), canvas.svg()?)?;
    files::write(&with_suffix(stem, ".png"), canvas.png()?)
}

/// Appends to the stem, which may itself have a dot (`fig5.a`).
fn with_suffix(stem: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(stem);
    name.push(suffix);
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stem in a folder of its own.
    fn stem(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("paper-repro-{name}-{}", std::process::id()));
        files::folder(Some(&folder)).unwrap().join("figure.1")
    }

    fn remove(stem: &Path) {
        std::fs::remove_dir_all(stem.parent().unwrap()).unwrap();
    }

    fn read(stem: &Path, suffix: &str) -> Vec<u8> {
        std::fs::read(with_suffix(stem, suffix)).unwrap()
    }

    #[test]
    fn charts_are_written_whatever_the_data() {
        let stem = stem("wild");
        let wild = vec![(0.0, f64::NAN), (1.0, -1e300), (2.0, 0.0), (f64::INFINITY, 1.0), (3.0, 1e300)];
        for points in [vec![], vec![(0.0, 0.0)], wild] {
            let series = Series { name: "a < b".to_owned(), points, ..Series::default() };
            for y in [Axis::default(), Axis::log("‖Φ‖ [m]", 1e-16)] {
                let chart = LineChart { y, series: vec![series.clone()], ..LineChart::default() };
                chart.save(&stem).unwrap();
                Panels { charts: vec![chart; 3], columns: 2, ..Panels::default() }.save(&stem).unwrap();
                assert!(read(&stem, ".png").starts_with(b"\x89PNG"));
            }
        }
        remove(&stem);
    }

    #[test]
    fn scenes_are_written_with_their_words() {
        let link = Shape::Polyline { points: vec![(0.0, 0.0), (9.0, 9.0)], colour: Colour::RED, width: 2.0 };
        let disc = Shape::Circle { centre: (1e6, 0.0), radius: 1.0, colour: Colour::BLUE, filled: true };
        let arrow = Shape::Arrow { from: (0.0, 0.0), to: (0.0, 0.0), colour: Colour::RED, label: "F(t)".to_owned() };
        let scene = Scene { title: "t = 0 s".to_owned(), shapes: vec![link, disc, arrow] };
        let range = Some(((-1.0, -1.0), (1.0, 1.0)));
        let chart =
            SceneChart { x_label: "x [m]".to_owned(), scenes: vec![scene; 3], columns: 2, range, ..SceneChart::default() };
        let stem = stem("scene");
        chart.save(&stem).unwrap();
        let svg = String::from_utf8(read(&stem, ".svg")).unwrap();
        assert!(["t = 0 s", "F(t)", "x [m]"].iter().all(|words| svg.contains(words)));
        SceneChart::default().save(&stem).unwrap();
        remove(&stem);
    }
}
