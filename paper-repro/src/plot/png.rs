//! Copies of figures as PNG, rendered with DejaVu Sans.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use crate::error::Error;

/// Pixels per point.
const PIXELS: f32 = 2.0;

/// The picture as PNG.
pub fn render(svg: &str) -> Result<Vec<u8>, Error> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        [dejavu::sans::regular(), dejavu::sans::bold()].into_iter().for_each(|bytes| fonts.load_font_data(bytes.to_vec()));
        fonts.set_sans_serif_family("DejaVu Sans");
        Arc::new(fonts)
    });
    let options = Options { fontdb: fonts.clone(), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(Error::drawing)?;
    let pixels = |points: f32| (points * PIXELS) as u32;
    let (width, height) = (pixels(tree.size().width()), pixels(tree.size().height()));
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| Error::drawing("a page without size"))?;
    pixmap.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(PIXELS, PIXELS), &mut pixmap.as_mut());
    pixmap.encode_png().map_err(Error::drawing)
}
