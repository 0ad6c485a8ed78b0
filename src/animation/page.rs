//! The HTML page: the template with the groups of the figure and the data of the motion.

use super::Animation;
use super::text::{escaped, list, quoted};
use super::vector::{COLOURS, groups, instead, opened, passed, poses};

const TEMPLATE: &str = include_str!("page.html");

pub(super) fn html(animation: &Animation) -> String {
    let Animation { title, times, plots, .. } = animation;
    let figure = &animation.figure.framed();
    let (groups, [under, above]) = groups(figure);
    let moving: String = groups.iter().map(|group| format!("<g class=\"moving\">{}</g>", group.shapes)).collect();
    let picture = format!(
        "{}<g>{under}</g><g id=\"trails\"></g>{moving}<g>{above}</g></g></svg>",
        opened(figure, title, "id=\"picture\"")
    );
    let poses = groups.iter().map(poses).collect::<Vec<_>>().join(",\n");
    let bodies = groups.iter().map(|group| group.is_body.to_string()).collect::<Vec<_>>().join(",");
    let colours = COLOURS.map(quoted).join(",");
    let plots = plots.iter().map(|plot| {
        format!("{{\"name\":{},\"unit\":{},\"values\":{}}}", quoted(&plot.name), quoted(&plot.unit), list(&plot.values))
    });
    let plots = plots.collect::<Vec<_>>().join(",\n");
    let seconds = passed(times).last().and_then(|duration| instead(*duration)).map_or("null".into(), |s| s.to_string());
    let data = format!(
        "{{\"times\":{},\n\"seconds\":{seconds},\n\"poses\":[{poses}],\n\"bodies\":[{bodies}],\n\"colours\":[{colours}],\n\"plots\":[{plots}]}}",
        list(times)
    );
    filled(&[("title", escaped(title)), ("picture", picture), ("data", data)])
}

/// The template with its placeholders replaced; the replacements are not searched for placeholders.
fn filled(texts: &[(&str, String)]) -> String {
    let text = |place: &str| texts.iter().find(|(name, _)| *name == place).map_or("", |(_, text)| text);
    let piece = |piece: &str| match piece.split_once("}}") {
        Some((place, rest)) => format!("{}{rest}", text(place)),
        None => piece.to_string(),
    };
    TEMPLATE.split("{{").map(piece).collect()
}
