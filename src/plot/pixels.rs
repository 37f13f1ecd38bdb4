//! Charts as pixels, with letters of 8 x 8 dots, so that no font has to be found.

use font8x8::UnicodeFonts;
use image::RgbImage;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};
use std::convert::Infallible;

/// Width of a letter in dots.
const LETTER: i32 = 8;
/// Text of this size and up is drawn at twice the dots.
const LARGE: f64 = 18.0;

/// A picture that charts are drawn into.
pub(super) struct Pixels<'a>(pub &'a mut RgbImage);

impl Pixels<'_> {
    fn blend(&mut self, (x, y): BackendCoord, color: BackendColor) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
        let Some(pixel) = self.0.get_pixel_mut_checked(x, y) else { return };
        let rgb = [color.rgb.0, color.rgb.1, color.rgb.2];
        for (to, from) in pixel.0.iter_mut().zip(rgb) {
            let mixed = f64::from(*to) * (1.0 - color.alpha) + f64::from(from) * color.alpha;
            *to = mixed.round() as u8;
        }
    }
}

fn dots(size: f64) -> i32 {
    if size >= LARGE { 2 } else { 1 }
}

fn extent(text: &str, size: f64) -> (i32, i32) {
    (text.chars().count() as i32 * LETTER * dots(size), LETTER * dots(size))
}

impl DrawingBackend for Pixels<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.0.dimensions()
    }

    fn ensure_prepared(&mut self) -> Result<(), DrawingErrorKind<Infallible>> {
        Ok(())
    }

    fn present(&mut self) -> Result<(), DrawingErrorKind<Infallible>> {
        Ok(())
    }

    fn draw_pixel(
        &mut self,
        point: BackendCoord,
        color: BackendColor,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        self.blend(point, color);
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let (w, h) = extent(text, style.size());
        Ok((w as u32, h as u32))
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        let (w, h) = extent(text, style.size());
        let left = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -w / 2,
            HPos::Right => -w,
        };
        let top = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -h / 2,
            VPos::Bottom => -h,
        };
        let dots = dots(style.size());
        for (k, letter) in text.chars().enumerate() {
            let Some(rows) = font8x8::BASIC_FONTS.get(letter) else { continue };
            for (j, row) in (0..).zip(rows) {
                for i in (0..LETTER).filter(|i| row >> i & 1 == 1) {
                    for (u, v) in (0..dots * dots).map(|d| (d % dots, d / dots)) {
                        let at = (left + (k as i32 * LETTER + i) * dots + u, top + j * dots + v);
                        let (dx, dy) = style.transform().transform(at.0, at.1);
                        self.blend((x + dx, y + dy), style.color());
                    }
                }
            }
        }
        Ok(())
    }
}
