//! The page: the template with the groups of the figure and the data of the motion.

use super::Animation;
use super::text::{escaped, list, quoted};
use super::vector::{COLOURS, groups, opened, poses};

const TEMPLATE: &str = include_str!("page.html");

pub(super) fn html(animation: &Animation) -> String {
    let Animation { title, times, figure, plots, .. } = animation;
    let (under, groups, above) = groups(figure);
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
    let data = format!(
        "{{\"times\":{},\n\"poses\":[{poses}],\n\"bodies\":[{bodies}],\n\"colours\":[{colours}],\n\"plots\":[{plots}]}}",
        list(times)
    );
    let places = [("{{title}}", escaped(title)), ("{{picture}}", picture), ("{{data}}", data)];
    // Each place is filled once, from the end, so that what is put in is not looked through.
    let mut page = TEMPLATE.to_string();
    for (place, text) in places.iter().rev() {
        if let Some(at) = page.rfind(place) {
            page.replace_range(at..at + place.len(), text);
        }
    }
    page
}
