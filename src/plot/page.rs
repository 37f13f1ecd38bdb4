//! HTML pages that need no other file.

use base64::Engine as _;
use image::{ImageFormat, RgbImage};
use std::fmt::Write;
use std::io::Cursor;

const STYLE: &str = "body{font:15px/1.5 sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;\
    color:#222}table{border-collapse:collapse;font-size:13px}td,th{border:1px solid #ccc;\
    padding:2px 8px;text-align:right}td:first-child,th:first-child{text-align:left}\
    tr.marked td{background:#eef5e6}img{image-rendering:pixelated;max-width:100%;\
    background:#000}.row{display:flex;gap:8px}.row figure{flex:1;margin:0}\
    .difference{position:relative;filter:brightness(8);isolation:isolate}\
    .difference img+img{position:absolute;left:0;top:0;mix-blend-mode:difference}";

/// A page under construction.
#[derive(Clone, Debug)]
pub struct Page {
    body: String,
    title: String,
}

impl Page {
    /// A page with a title.
    pub fn new(title: &str) -> Self {
        Self { body: format!("<h1>{}</h1>\n", escape(title)), title: escape(title) }
    }

    /// A heading.
    pub fn heading(&mut self, text: &str) {
        let _ = writeln!(self.body, "<h2>{}</h2>", escape(text));
    }

    /// A paragraph of plain text.
    pub fn text(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
    }

    /// Text whose lines stay as they are.
    pub fn lines(&mut self, text: &str) {
        let _ = writeln!(self.body, "<pre>{}</pre>", escape(text));
    }

    /// A drawing.
    pub fn svg(&mut self, svg: &str) {
        self.body.push_str(svg);
    }

    /// A table; rows whose number is in `marked` stand out.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>], marked: &[usize]) {
        self.body.push_str("<table>\n");
        let line = |cells: &mut dyn Iterator<Item = &str>, tag: &str| -> String {
            cells.map(|c| format!("<{tag}>{}</{tag}>", escape(c))).collect()
        };
        if !head.is_empty() {
            let _ = writeln!(self.body, "<tr>{}</tr>", line(&mut head.iter().copied(), "th"));
        }
        for (i, row) in rows.iter().enumerate() {
            let class = if marked.contains(&i) { " class=\"marked\"" } else { "" };
            let cells = line(&mut row.iter().map(String::as_str), "td");
            let _ = writeln!(self.body, "<tr{class}>{cells}</tr>");
        }
        self.body.push_str("</table>\n");
    }

    /// A picture.
    pub fn picture(&mut self, picture: &RgbImage, alt: &str) {
        let _ = writeln!(self.body, "{}", image(picture, alt));
    }

    /// Pictures of one size beside each other, and then what each differs from the last, eight times as
    /// bright.
    pub fn compare(&mut self, pictures: &[(String, RgbImage)]) {
        let Some((last_name, last)) = pictures.last() else { return };
        let last = image(last, last_name);
        self.body.push_str("<div class=\"row\">");
        for (name, picture) in pictures {
            let (image, name) = (image(picture, name), escape(name));
            let _ = write!(self.body, "<figure>{image}<figcaption>{name}</figcaption></figure>");
        }
        self.body.push_str("</div>\n<div class=\"row\">");
        for (name, picture) in &pictures[..pictures.len() - 1] {
            let image = image(picture, name);
            let caption = format!("{name} less {last_name}, eight times");
            let _ = write!(
                self.body,
                "<figure><div class=\"difference\">{image}{last}</div><figcaption>{}</figcaption>\
                 </figure>",
                escape(&caption)
            );
        }
        self.body.push_str("</div>\n");
    }

    /// The whole page.
    pub fn finish(self) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{}</title>\n\
             <style>{STYLE}</style></head>\n<body>\n{}</body></html>\n",
            self.title, self.body
        )
    }
}

/// A picture within the page.
fn image(picture: &RgbImage, alt: &str) -> String {
    let mut png = Cursor::new(Vec::new());
    if picture.write_to(&mut png, ImageFormat::Png).is_err() {
        return String::new();
    }
    let data = base64::engine::general_purpose::STANDARD.encode(png.get_ref());
    format!("<img alt=\"{}\" src=\"data:image/png;base64,{data}\">", escape(alt))
}

/// Text as HTML shows it.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_stand_alone_and_escape_text() {
        let mut page = Page::new("a<b");
        page.table(&["x"], &[vec!["<script>".into()]], &[0]);
        let black = RgbImage::new(2, 2);
        page.compare(&[("one".into(), black.clone()), ("two".into(), black)]);
        let html = page.finish();
        assert!(html.contains("a&lt;b") && html.contains("&lt;script&gt;"));
        assert!(!html.contains("<script") && !html.contains("http"));
        assert_eq!(html.matches("data:image/png;base64,").count(), 4);
    }
}
