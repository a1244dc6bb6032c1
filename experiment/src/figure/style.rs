//! How all figures are drawn: with plotters, as SVG, in the same ink and letters.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::Pos;

/// Plotters rounds to whole pixels: draw larger by this and let the viewer scale.
const SCALE: i32 = 8;
/// Sizes of the letters, px.
pub(crate) const LARGE: i32 = 16;
pub(crate) const SMALL: i32 = 14;

pub(crate) const INK: RGBColor = RGBColor(40, 40, 40);
pub(crate) const FAINT: RGBColor = RGBColor(205, 205, 205);

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(crate) type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
pub(crate) type Drawn<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// What `draw` draws on a white area of `width` times `height` px, as SVG.
pub(crate) fn svg(width: i32, height: i32, draw: impl FnOnce(&Area<'_>) -> Drawn) -> Drawn<String> {
    let mut svg = String::new();
    let size = (SCALE as u32 * width as u32, SCALE as u32 * height as u32);
    let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    root.fill(&WHITE)?;
    draw(&root)?;
    root.present()?;
    drop(root);
    let size = |scale| format!(r#"width="{}" height="{}" viewBox"#, scale * width, scale * height);
    Ok(svg.replacen(&size(SCALE), &size(1), 1))
}

pub(crate) fn line<C>(points: impl IntoIterator<Item = C>, colour: RGBColor, width: i32) -> PathElement<C> {
    let points: Vec<_> = points.into_iter().collect();
    PathElement::new(points, colour.stroke_width(px(width) as u32))
}

pub(crate) fn font(size: i32) -> TextStyle<'static> {
    // Plotters writes 1 / 1.24 of the size.
    ("sans-serif", 1.24 * f64::from(px(size))).into()
}

pub(crate) fn label(
    text: &str,
    at: (i32, i32),
    size: i32,
    pos: Pos,
    colour: RGBColor,
) -> Text<'static, (i32, i32), String> {
    let color = colour.to_backend_color();
    let style = TextStyle {
        color,
        pos,
        ..font(size)
    };
    Text::new(text.to_owned(), (px(at.0), px(at.1)), style)
}

/// Pixels of the figure in those that are drawn.
pub(crate) fn px(pixels: i32) -> i32 {
    SCALE * pixels
}
