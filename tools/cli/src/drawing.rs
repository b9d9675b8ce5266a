//! Figures as files: SVG, PNG or a page, by the ending of the file's name.

use crate::Failure;
use crate::existing::{Force, check_place, title};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use std::path::Path;
use std::sync::Arc;

/// Pixels of a PNG for a unit of the SVG.
const SCALE: f32 = 2.0;

/// The formats.
#[derive(Clone, Copy, PartialEq)]
enum Format {
    Svg,
    Png,
    Html,
}

impl Format {
    fn of(path: &Path) -> Result<Format, Failure> {
        match path.extension().map(|e| e.to_ascii_lowercase()).as_ref().and_then(|e| e.to_str()) {
            Some("svg") => Ok(Format::Svg),
            Some("png") => Ok(Format::Png),
            Some("html") => Ok(Format::Html),
            _ => Err(Failure::new(format!(
                "{}: the name of a figure ends in .svg, .png or .html",
                path.display()
            ))),
        }
    }
}

/// Refuses a name without format, and a file that is no earlier figure with such a title.
pub fn check(
    path: Option<&Path>,
    force: Force,
    what: &str,
    is_title: impl Fn(&str) -> bool,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    Format::of(path)?;
    check_place(path)?;
    force.check_titled(path, what, is_title)
}

/// Writes a figure in the format of the name.
pub fn write(path: &Path, svg: &str) -> Result<(), Failure> {
    let bytes = match Format::of(path)? {
        Format::Svg => svg.as_bytes().to_vec(),
        Format::Png => png(svg)?,
        Format::Html => {
            present::page::page_of_figure(&title(svg.as_bytes()).unwrap_or_default(), svg).into_bytes()
        }
    };
    std::fs::write(path, bytes).map_err(|e| crate::unwritten(path, &e))
}

/// The figure as pixels, in its light colours; the fonts of the machine do not matter.
fn png(svg: &str) -> Result<Vec<u8>, Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::new(format!("the figure cannot be drawn as PNG: {e}"));
    let mut fonts = fontdb::Database::new();
    for font in [dejavu::sans::regular(), dejavu::sans::bold()] {
        fonts.load_font_data(font.to_vec());
    }
    fonts.set_sans_serif_family("DejaVu Sans");
    let options =
        Options { font_family: "DejaVu Sans".to_owned(), fontdb: Arc::new(fonts), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|e| failed(&e))?;
    let size = tree.size().to_int_size().scale_by(SCALE).ok_or_else(|| failed(&"it has no size"))?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or_else(|| failed(&"it is too large"))?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.width(), size.height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    if let Some(title) = title(svg.as_bytes()) {
        encoder.add_itxt_chunk("Title".to_owned(), title).map_err(|e| failed(&e))?;
    }
    let mut writer = encoder.write_header().map_err(|e| failed(&e))?;
    // The paper is opaque, so that colours multiplied by their opacity are the colours.
    writer.write_image_data(pixels.data()).map_err(|e| failed(&e))?;
    writer.finish().map_err(|e| failed(&e))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use present::figure::{Axis, Figure};

    /// A line from corner to corner: the picture has its colour, the paper and letters, and each format has the title.
    #[test]
    fn a_figure_becomes_pixels_and_a_page() {
        let folder = tempfile::tempdir().unwrap();
        let figure = Figure::new("Höhe < 3", Axis::new("time in s"), Axis::new("current in A"));
        let svg = figure.line("current", vec![(0.0, 0.0), (1.0, 1.0)]).svg();
        for name in ["f.svg", "f.PNG", "f.html"] {
            let path = folder.path().join(name);
            write(&path, &svg).unwrap();
            assert_eq!(title(&std::fs::read(&path).unwrap()).as_deref(), Some("Höhe < 3"), "{name}");
        }
        // The title is written once.
        let page = std::fs::read_to_string(folder.path().join("f.html")).unwrap();
        assert_eq!(page.matches(">Höhe &lt; 3<").count(), 2, "title of the page and of the figure: {page}");
        let mut reader = png::Decoder::new(std::io::Cursor::new(png(&svg).unwrap())).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let count = |wanted: [u8; 3]| pixels.chunks(4).filter(|p| p[..3] == wanted).count();
        let (paper, line, ink) = (count([255; 3]), count([0, 0x72, 0xb2]), count([0x24, 0x29, 0x2f]));
        println!("{} x {}: paper {paper}, line {line}, ink {ink}", info.width, info.height);
        assert_eq!(info.width, 1000);
        assert!(paper > 400_000 && line > 2000 && ink > 200);
        assert!(write(&folder.path().join("f.jpg"), &svg).is_err());
    }
}
