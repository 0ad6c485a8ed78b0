//! SVG: the shapes of a figure as groups that move as a whole, and pictures composed of them.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use super::figure::{Arrow, Figure, Link, LinkKind, Mark, MarkKind, Outline, Piece};
use super::text::{digits, escaped, list, number};

/// Colours of the bodies, in turn.
pub(super) const COLOURS: [&str; 8] =
    ["#4e79a7", "#f28e2b", "#59a14f", "#b07aa1", "#76b7b2", "#e15759", "#edc948", "#9c755f"];
pub(super) const INK: &str = "#333";
/// Maximum number of frames of an animated SVG.
const MOST_KEYS: usize = 150;
/// Durations, s, shown in real time: browsers cannot resolve shorter ones, and longer ones take too long. Others are shown in `INSTEAD` s.
const WATCHED: RangeInclusive<f64> = 1e-5..=1e7;
const INSTEAD: f64 = 10.0;
/// Length of the longer side of a picture, pixels.
const PIXELS: f64 = 640.0;
/// The length of the longest arrow, in units of marks.
const ARROW: f64 = 12.0;

/// A group that moves as a whole: its shapes, and x, y, φ and the scales along its axes in every frame.
pub(super) struct Group {
    pub(super) shapes: String,
    pub(super) poses: Vec<[f64; 5]>,
    /// True for a body, whose origin leaves a trail.
    pub(super) is_body: bool,
    /// Index of the group with which it moves.
    follows: Option<usize>,
}

/// Text shown if there is nothing to draw.
const NOTHING: [&str; 2] = ["No part of this scene can be drawn.", "Add lines by Animation::line."];

/// Writer of shapes; their lengths are in metres.
struct Pen {
    unit: f64,
    digits: usize,
}

impl Pen {
    fn new(figure: &Figure) -> Self {
        Pen { unit: figure.unit, digits: digits(figure.view[2].max(figure.view[3])) + 1 }
    }

    fn n(&self, x: f64) -> String {
        number(x, self.digits)
    }

    /// A length in units of marks.
    fn u(&self, x: f64) -> String {
        self.n(x * self.unit)
    }

    fn path(&self, points: &[[f64; 2]], closed: bool) -> String {
        let points: Vec<String> = points.iter().map(|[x, y]| format!("{} {}", self.n(*x), self.n(*y))).collect();
        format!("M{}{}", points.join("L"), if closed { "Z" } else { "" })
    }

    fn circle(&self, [x, y]: [f64; 2], radius: f64, style: &str) -> String {
        format!("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {style}/>", self.n(x), self.n(y), self.n(radius))
    }

    /// Lines of text in the middle of the view of an empty figure.
    fn note(&self, lines: [&str; 2]) -> String {
        let text = |(k, line): (usize, &str)| {
            let (x, y) = (self.n(0.5), self.u(4.0 * k as f64 - 42.0));
            format!(
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"middle\" fill=\"{INK}\">{line}</text>",
                self.u(3.5)
            )
        };
        format!("<g transform=\"scale(1 -1)\">{}</g>", lines.into_iter().enumerate().map(text).collect::<String>())
    }

    fn line(&self, width: f64) -> String {
        format!("fill=\"none\" stroke=\"{INK}\" stroke-width=\"{}\"", self.u(width))
    }

    fn body(&self, piece: &Piece, colour: &str) -> String {
        let u = self.unit;
        let shape = match &piece.outline {
            Outline::Hull(points) => format!(
                "<path d=\"{}\" fill=\"{colour}\" fill-opacity=\".45\" stroke=\"{colour}\" stroke-width=\"{}\" stroke-linejoin=\"round\" stroke-linecap=\"round\"/>",
                self.path(points, true),
                self.u(1.6)
            ),
            Outline::Carriage([x, y], angle) => format!(
                "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"{}\" fill=\"{colour}\" transform=\"translate({} {})rotate({})\"/>",
                self.u(-4.0),
                self.u(-2.2),
                self.u(8.0),
                self.u(4.4),
                self.u(0.8),
                self.n(*x),
                self.n(*y),
                number(angle.to_degrees(), 2)
            ),
            Outline::Disc => self.circle([0.0; 2], 2.0 * u, &format!("fill=\"{colour}\"")),
            Outline::Dot => self.circle([0.0; 2], 0.9 * u, &format!("fill=\"{INK}\"")),
        };
        let centre = self.circle([0.0; 2], 0.45 * u, "fill=\"#fff\" fill-opacity=\".8\"");
        format!("<title>{}</title>{shape}{centre}", escaped(&piece.name))
    }

    /// The parts of a mark below the bodies and above them.
    fn mark(&self, mark: &Mark) -> [String; 2] {
        let (u, [x, y], on_ground) = (self.unit, mark.place.at, mark.place.body.is_none());
        let turned = |angle: f64, shapes: String| {
            let (x, y) = (self.n(x), self.n(y));
            format!("<g transform=\"translate({x} {y})rotate({})\">{shapes}</g>", number(angle.to_degrees(), 2))
        };
        let line =
            |points: &[[f64; 2]], width: f64| format!("<path d=\"{}\" {}/>", self.path(points, false), self.line(width));
        let long = if on_ground { 400.0 * u } else { 12.0 * u };
        let none = String::new();
        let [under, above] = match mark.kind {
            MarkKind::Hinge => {
                let foot = [[0.0, 0.0], [-2.0 * u, -3.2 * u], [2.0 * u, -3.2 * u]];
                let style = format!("fill=\"#ccc\" stroke=\"{INK}\" stroke-width=\"{}\"", self.u(0.3));
                let foot = format!("<path d=\"{}\" {style}/>", self.path(&foot, true));
                let style = format!("fill=\"#fff\" stroke=\"{INK}\" stroke-width=\"{}\"", self.u(0.45));
                [if on_ground { turned(0.0, foot) } else { none }, self.circle([x, y], 0.9 * u, &style)]
            }
            MarkKind::Rail(angle) => [turned(angle, line(&[[-long, 0.0], [long, 0.0]], 0.4)), none],
            MarkKind::Weld => [none, self.circle([x, y], 0.7 * u, &format!("fill=\"{INK}\""))],
            MarkKind::Surface(normal) => [turned(normal, line(&[[0.0, -long], [0.0, long]], 0.8)), none],
            MarkKind::Wheel(radius) => {
                let dashes = format!("{} stroke-dasharray=\"{} {}\"", self.line(0.4), self.u(1.2), self.u(0.8));
                let spoke = line(&[[0.0, 0.0], [radius, 0.0]], 0.3);
                [none, format!("{}{spoke}", self.circle([x, y], radius, &dashes))]
            }
            MarkKind::Wall(end) => [line(&[[x, y], end], 1.2), none],
            MarkKind::Obstacle(radius) => {
                let style = format!("fill=\"#ccc\" stroke=\"{INK}\" stroke-width=\"{}\"", self.u(0.3));
                [self.circle([x, y], radius, &style), none]
            }
            MarkKind::Target => {
                let arm = 1.8 * u;
                let cross = [[[x - arm, y], [x + arm, y]], [[x, y - arm], [x, y + arm]]].map(|ends| line(&ends, 0.5));
                [none, cross.concat() + &self.circle([x, y], 1.2 * u, &self.line(0.4))]
            }
        };
        let name = escaped(&mark.name);
        [under, above].map(|shapes| if shapes.is_empty() { shapes } else { format!("<g><title>{name}</title>{shapes}</g>") })
    }

    /// A link from 0 to 1 along x; its group is stretched to the length of the link.
    fn link(&self, link: &Link) -> String {
        let u = self.unit;
        let straight = |width: f64, from: f64, to: f64, colour: &str| {
            format!(
                "<path d=\"M{from} 0L{to} 0\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" vector-effect=\"none\"/>",
                self.u(width)
            )
        };
        let shapes = match link.kind {
            LinkKind::Rod => straight(0.9, 0.0, 1.0, INK),
            LinkKind::Cylinder => straight(0.9, 0.45, 1.0, "#888") + &straight(2.2, 0.0, 0.6, "#555"),
            LinkKind::Spring => {
                let zigzag = (0..=16).map(|k| {
                    let side = if k % 2 == 0 { -1.2 } else { 1.2 };
                    [0.1 + 0.05 * f64::from(k), if (1..16).contains(&k) { side * u } else { 0.0 }]
                });
                let points: Vec<[f64; 2]> = [[0.0, 0.0]].into_iter().chain(zigzag).chain([[1.0, 0.0]]).collect();
                let points: Vec<String> = points.iter().map(|[x, y]| format!("{} {}", number(*x, 3), self.n(*y))).collect();
                // The group is stretched along the spring; strokes that scale with it would be thick where they are steep.
                format!(
                    "<path d=\"M{}\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.2\" vector-effect=\"non-scaling-stroke\"/>",
                    points.join("L")
                )
            }
        };
        format!("<title>{}</title>{shapes}", escaped(&link.name))
    }

    fn arrow(&self, arrow: &Arrow) -> String {
        let u = self.unit;
        let colour = "#d62728";
        let shapes = match arrow.axis {
            Some(_) => {
                let (tip, back) = (ARROW * u, (ARROW - 2.5) * u);
                let shaft = format!("M0 0L{} 0", self.n(back));
                let head = self.path(&[[back, -1.2 * u], [tip, 0.0], [back, 1.2 * u]], true);
                format!(
                    "<path d=\"{shaft}\" stroke=\"{colour}\" stroke-width=\"{}\"/><path d=\"{head}\" fill=\"{colour}\"/>",
                    self.u(0.8)
                )
            }
            None => {
                let r = 4.0 * u;
                let arc = format!("M{r} 0A{r} {r} 0 1 1 0 {}", self.n(-r), r = self.n(r));
                let head = self.path(&[[-0.2 * u, -r - 1.3 * u], [2.0 * u, -r], [-0.2 * u, -r + 1.3 * u]], true);
                format!(
                    "<path d=\"{arc}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\"/><path d=\"{head}\" fill=\"{colour}\"/>",
                    self.u(0.7)
                )
            }
        };
        format!("<title>{}</title>{shapes}", escaped(&arrow.name))
    }
}

/// Moving groups in the order in which they are drawn, and the fixed shapes below and above them.
pub(super) fn groups(figure: &Figure) -> (Vec<Group>, [String; 2]) {
    let pen = Pen::new(figure);
    let marks_of = |body: Option<usize>| -> [String; 2] {
        let marks: Vec<[String; 2]> =
            figure.marks.iter().filter(|mark| mark.place.body == body).map(|mark| pen.mark(mark)).collect();
        [0, 1].map(|layer| marks.iter().map(|mark| mark[layer].as_str()).collect())
    };
    let mut all = Vec::new();
    for (body, piece) in figure.bodies.iter().enumerate() {
        let [under, _] = marks_of(Some(body));
        let shapes = under + &pen.body(piece, COLOURS[body % COLOURS.len()]);
        let poses = piece.poses.iter().map(|&[x, y, phi]| [x, y, phi, 1.0, 1.0]).collect();
        all.push(Group { shapes, poses, is_body: true, follows: None });
    }
    for link in &figure.links {
        all.push(Group { shapes: pen.link(link), poses: link_poses(figure, link), is_body: false, follows: None });
    }
    for body in 0..figure.bodies.len() {
        let [_, shapes] = marks_of(Some(body));
        if !shapes.is_empty() {
            let poses = all[body].poses.clone();
            all.push(Group { shapes, poses, is_body: false, follows: Some(body) });
        }
    }
    for arrow in &figure.arrows {
        all.push(Group { shapes: pen.arrow(arrow), poses: arrow_poses(figure, arrow), is_body: false, follows: None });
    }
    let [under, above] = marks_of(None);
    (all, [under, if figure.is_empty() { pen.note(NOTHING) } else { above }])
}

fn link_poses(figure: &Figure, link: &Link) -> Vec<[f64; 5]> {
    let mut last = 0.0;
    let pose = |frame| {
        let [[x, y], [x1, y1]] = link.ends.map(|end| figure.position(end, frame));
        let angle = (y1 - y).atan2(x1 - x);
        // Makes the angle continuous where atan2 jumps.
        last = angle + TAU * ((last - angle) / TAU).round();
        [x, y, last, (x1 - x).hypot(y1 - y), 1.0]
    };
    (0..figure.frames).map(pose).collect()
}

fn arrow_poses(figure: &Figure, arrow: &Arrow) -> Vec<[f64; 5]> {
    let pose = |(frame, &value): (usize, &f64)| {
        let [x, y] = figure.position(arrow.place, frame);
        match arrow.axis {
            Some((body, angle)) => {
                let turned = body.map_or(0.0, |body| figure.bodies[body].poses[frame][2]);
                [x, y, turned + angle, value, value.abs()]
            }
            None => [x, y, 0.0, value.abs(), value],
        }
    };
    arrow.values.iter().enumerate().map(pose).collect()
}

/// Opens the picture and the group in which y points up.
pub(super) fn opened(figure: &Figure, title: &str, attributes: &str) -> String {
    let ([left, bottom, width, height], digits) = (figure.view, Pen::new(figure).digits);
    let view = [left, -(bottom + height), width, height].map(|x| number(x, digits)).join(" ");
    let title = escaped(title);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{view}\" role=\"img\" aria-label=\"{title}\" {attributes}><title>{title}</title><g transform=\"scale(1 -1)\">"
    )
}

/// A complete picture with a white background.
pub(super) fn picture(figure: &Figure, title: &str, shapes: [&str; 3]) -> String {
    let [left, bottom, width, height] = figure.view;
    let [wide, high] = [width, height].map(|x| number(x * PIXELS / width.max(height), 0));
    let [left, bottom, width, height] = [left, bottom, width, height].map(|x| number(x, Pen::new(figure).digits));
    let (opened, shapes) = (opened(figure, title, &format!("width=\"{wide}\" height=\"{high}\"")), shapes.concat());
    let rest = format!(
        "<rect x=\"{left}\" y=\"{bottom}\" width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>{shapes}</g></svg>\n"
    );
    opened + &rest
}

/// A picture of one frame.
pub(super) fn still(figure: &Figure, frame: usize, title: &str) -> String {
    let (groups, [under, above]) = groups(figure);
    let digits = Pen::new(figure).digits;
    let moved = groups.iter().map(|group| {
        let [x, y, phi, along, across] = group.poses[frame];
        let [x, y, along, across] = [x, y, along, across].map(|x| number(x, digits));
        let angle = number(phi.to_degrees(), 2);
        format!("<g transform=\"translate({x} {y})rotate({angle})scale({along} {across})\">{}</g>", group.shapes)
    });
    picture(figure, title, [&under, &moved.collect::<String>(), &above])
}

/// The duration in seconds for a motion that is not shown in real time.
pub(super) fn instead(duration: f64) -> Option<f64> {
    (duration > 0.0 && !WATCHED.contains(&duration)).then_some(INSTEAD)
}

/// Time since the first frame, also for motions that go back in time.
pub(super) fn passed(times: &[f64]) -> Vec<f64> {
    let step = |passed: &mut f64, i: usize| {
        *passed += (times[i] - times[i.saturating_sub(1)]).abs();
        Some(*passed)
    };
    (0..times.len()).scan(0.0, step).collect()
}

/// The frames that an endless loop shows, and the attributes that say when.
pub(super) struct Keys {
    pub(super) frames: Vec<usize>,
    pub(super) timing: String,
}

impl Keys {
    /// `None` if the motion takes no time.
    pub(super) fn new(frames: usize, times: &[f64], most: usize) -> Option<Self> {
        let last = frames.saturating_sub(1);
        let spaces = last.min(most - 1);
        // Evenly spaced, including the last one.
        let frames: Vec<usize> = (0..=spaces).map(|key| key * last / spaces.max(1)).collect();
        let passed = passed(times);
        let duration = passed[last];
        let shown = instead(duration).unwrap_or(duration);
        let key_times = frames.iter().map(|&frame| number(passed[frame] / duration, 4)).collect::<Vec<_>>().join(";");
        let seconds = number(shown, digits(shown).max(3));
        let timing = format!("keyTimes=\"{key_times}\" dur=\"{seconds}s\" repeatCount=\"indefinite\"");
        (duration > 0.0).then_some(Keys { frames, timing })
    }
}

/// All frames in an endless loop.
pub(super) fn animated(figure: &Figure, times: &[f64], title: &str) -> String {
    let (groups, [under, above]) = groups(figure);
    let last = figure.frames.saturating_sub(1);
    let Some(Keys { frames: keys, timing }) = Keys::new(figure.frames, times, MOST_KEYS) else {
        return still(figure, last, title);
    };
    let digits = Pen::new(figure).digits;
    let moved = groups.iter().map(|group| {
        let animate = |kind: &str, value: &dyn Fn([f64; 5]) -> String| {
            let values = keys.iter().map(|&frame| value(group.poses[frame])).collect::<Vec<_>>().join(";");
            format!("<animateTransform attributeName=\"transform\" type=\"{kind}\" values=\"{values}\" {timing}/>")
        };
        let moved_to = |[x, y, ..]: [f64; 5]| format!("{} {}", number(x, digits), number(y, digits));
        let turned = |[_, _, phi, ..]: [f64; 5]| number(phi.to_degrees(), 2);
        let (translate, rotate) = (animate("translate", &moved_to), animate("rotate", &turned));
        let inner = if group.poses.iter().all(|pose| pose[3..] == [1.0, 1.0]) {
            group.shapes.clone()
        } else {
            let scaled = |[.., x, y]: [f64; 5]| format!("{} {}", number(x, digits), number(y, digits));
            let scale = animate("scale", &scaled);
            format!("<g transform=\"scale({})\">{scale}{}</g>", scaled(group.poses[last]), group.shapes)
        };
        // Viewers without animations show the last frame.
        let [at, angle] = [moved_to(group.poses[last]), turned(group.poses[last])];
        format!("<g transform=\"translate({at})\">{translate}<g transform=\"rotate({angle})\">{rotate}{inner}</g></g>")
    });
    picture(figure, title, [&under, &moved.collect::<String>(), &above])
}

/// The poses of a group as JSON, column by column, or the index of the group with which it moves; scales that are all 1 are left out.
pub(super) fn poses(group: &Group) -> String {
    if let Some(other) = group.follows {
        return other.to_string();
    }
    let column = |k: usize| list(&group.poses.iter().map(|pose| pose[k]).collect::<Vec<f64>>());
    let count = if group.poses.iter().all(|pose| pose[3..] == [1.0, 1.0]) { 3 } else { 5 };
    format!("[{}]", (0..count).map(column).collect::<Vec<_>>().join(","))
}
