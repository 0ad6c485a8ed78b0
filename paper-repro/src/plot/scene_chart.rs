//! Pictures of a planar mechanism, with one scale for both directions.

use super::{
    Colour, Point, Shape,
    axis::{Ruler, extent},
    canvas::Canvas,
    csv,
    frame::{self, Frame, LARGE, Margins, Rect},
    legend::{Entry, Legend},
    panels::titled_page,
};
use crate::error::Error;
use std::path::Path;

/// One picture.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Over the picture, such as its time.
    pub title: String,
    /// What is drawn, later over earlier.
    pub shapes: Vec<Shape>,
}

/// Pictures of a mechanism in a grid, all of the same stretch of the plane.
#[derive(Clone, Debug)]
pub struct SceneChart {
    /// Over all pictures, if not empty.
    pub title: String,
    /// The horizontal axis; with neither label the pictures have no frame.
    pub x_label: String,
    /// The vertical axis.
    pub y_label: String,
    /// What the colours mean, in a row under the title.
    pub key: Vec<(String, Colour)>,
    /// The pictures, row by row.
    pub scenes: Vec<Scene>,
    /// How many stand side by side.
    pub columns: usize,
    /// The least and the greatest corner shown, which clip lines and trails, found from the shapes if not given.
    pub range: Option<(Point, Point)>,
    /// Width in points; the height follows from the pictures.
    pub width: f64,
}

impl Default for SceneChart {
    fn default() -> Self {
        Self {
            title: String::new(),
            x_label: String::new(),
            y_label: String::new(),
            key: Vec::new(),
            scenes: Vec::new(),
            columns: 1,
            range: None,
            width: 700.0,
        }
    }
}

impl SceneChart {
    /// Writes `<stem>.svg`, `<stem>.png` and `<stem>.csv`.
    pub fn save(&self, stem: &Path) -> Result<(), Error> {
        const GAP: f64 = 8.0;
        let columns = self.columns.max(1);
        let rows = self.scenes.len().div_ceil(columns).max(1);
        let ((left, low), (right, high)) = self.shown();
        let (x, y) = (Ruler::linear(left, right), Ruler::linear(low, high));

        let entries: Vec<Entry<'_>> = self.key.iter().map(key_entry).collect();
        let key_height = Legend::Above.height_above(&entries, self.width) + if entries.is_empty() { 0.0 } else { 4.0 };

        let cell_width = (self.width - 8.0 + GAP) / columns as f64 - GAP;
        let guess = cell_width * (high - low) / (right - left);
        let y_ticks = y.ticks(frame::ticks_along(guess, 34.0));
        let margins = self.margins(&y_ticks);
        let picture_width = (cell_width - margins.left - margins.right).max(1.0);
        let cell_height = margins.top + picture_width * (high - low) / (right - left) + margins.bottom;
        let height = 8.0 + key_height + rows as f64 * (cell_height + GAP) - GAP;
        let (mut canvas, page) = titled_page(&self.title, (self.width, height));

        let grid = Rect { top: page.top + key_height, ..page };
        Legend::Above.draw(&mut canvas, &entries, Rect { top: grid.top - 4.0, ..grid });
        for (index, scene) in self.scenes.iter().enumerate() {
            let rect = grid.cell(index, columns, rows, GAP).inside(margins);
            self.draw(&mut canvas, scene, &Frame { rect, x, y });
        }
        super::save(stem, &canvas, &self.csv())
    }

    /// Draws one picture.
    fn draw(&self, canvas: &mut Canvas, scene: &Scene, frame: &Frame) {
        for shape in &scene.shapes {
            shape.draw(canvas, frame);
        }
        let x_ticks = frame.x.ticks(frame::ticks_along(frame.rect.width(), 50.0));
        let y_ticks = frame.y.ticks(frame::ticks_along(frame.rect.height(), 34.0));
        frame.title(canvas, &scene.title, 0.8 * LARGE);
        if self.has_frame() {
            frame.outline(canvas);
            frame.x_axis(canvas, &x_ticks, &self.x_label);
            frame.y_axis(canvas, &y_ticks, &self.y_label, Colour::BLACK, false);
        }
    }

    /// The room around each picture.
    fn margins(&self, y_ticks: &[super::axis::Tick]) -> Margins {
        let top = if self.scenes.iter().all(|scene| scene.title.is_empty()) { 8.0 } else { 2.0 * LARGE };
        if self.has_frame() {
            let (left, bottom) = (frame::beside(y_ticks, &self.y_label), frame::below(&self.x_label));
            Margins { left, top, right: 10.0, bottom }
        } else {
            Margins { left: 0.0, top, right: 0.0, bottom: 0.0 }
        }
    }

    /// Whether the pictures have frames and axes.
    fn has_frame(&self) -> bool {
        !(self.x_label.is_empty() && self.y_label.is_empty())
    }

    /// The least and the greatest corner of what is shown, with a margin around the shapes.
    fn shown(&self) -> (Point, Point) {
        const MARGIN: f64 = 0.06;
        if let Some(range) = self.range {
            return range;
        }
        let points: Vec<Point> = self.scenes.iter().flat_map(|scene| scene.shapes.iter().flat_map(Shape::outline)).collect();
        let finite = |value: &f64| value.is_finite();
        let (left, right) = extent(points.iter().map(|point| point.0).filter(finite)).unwrap_or((0.0, 1.0));
        let (low, high) = extent(points.iter().map(|point| point.1).filter(finite)).unwrap_or((0.0, 1.0));
        let size = (right - left).max(high - low);
        let room = if size > 0.0 { MARGIN * size } else { 1.0 };
        ((left - room, low - room), (right + room, high + room))
    }

    /// The outlines of all shapes.
    fn csv(&self) -> String {
        let mut out = csv::line(["panel", "shape", "kind", "x", "y"].map(str::to_owned));
        for (panel, scene) in self.scenes.iter().enumerate() {
            let panel = if scene.title.is_empty() { (panel + 1).to_string() } else { scene.title.clone() };
            for (id, shape) in scene.shapes.iter().enumerate() {
                for (x, y) in shape.outline() {
                    let place = [panel.clone(), (id + 1).to_string(), shape.kind().to_owned()];
                    out += &csv::line(place.into_iter().chain([csv::number(x), csv::number(y)]));
                }
            }
        }
        out
    }
}

/// A line of the key.
fn key_entry((name, colour): &(String, Colour)) -> Entry<'_> {
    let sample = Box::new(|canvas: &mut Canvas, from, to| canvas.line(vec![from, to], *colour, 3.0));
    Entry { name, sample }
}
