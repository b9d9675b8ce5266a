//! stub
use super::paper::Paper;
use super::thesis::Thesis;

/// A page and its figures.
pub struct Page {
    /// Name of the page's file, without ending.
    pub name: &'static str,
    /// The page, complete in itself.
    pub html: String,
    /// Figures as files of their own: name without ending, SVG.
    pub figures: Vec<(String, String)>,
}

/// The page about the thesis.
pub fn thesis(_thesis: &Thesis) -> Page {
    Page { name: "thesis", html: String::new(), figures: Vec::new() }
}

/// The page about the paper.
pub fn paper(_paper: &Paper) -> Page {
    Page { name: "paper", html: String::new(), figures: Vec::new() }
}
