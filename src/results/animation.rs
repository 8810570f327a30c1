//! Animated GIF files of drawings.

use gif::{Encoder, Frame, Repeat};

use super::drawing::Drawing;

/// Speed of the choice of colours, from 1 (best) to 30.
const SPEED: i32 = 10;

/// An animation that repeats for ever. All drawings have the size of the first one.
pub struct Animation {
    /// Time of each drawing in 1/100 s.
    delay: u16,
    encoder: Option<Encoder<Vec<u8>>>,
}

impl Animation {
    /// Creates an animation without drawings; each is shown for `seconds`, at least 0.02 s.
    pub fn new(seconds: f64) -> Animation {
        Animation { delay: (100.0 * seconds).round().clamp(2.0, f64::from(u16::MAX)) as u16, encoder: None }
    }

    /// Adds a drawing.
    ///
    /// # Errors
    /// If there is not enough memory, or if the drawing is larger than a GIF file can be (65 535 pixels).
    pub fn push(&mut self, drawing: &Drawing) -> Result<(), String> {
        let pixels = drawing.pixels()?;
        let side = |length: u32| u16::try_from(length).map_err(|e| e.to_string());
        let (width, height) = (side(pixels.width())?, side(pixels.height())?);
        let encoder = match &mut self.encoder {
            Some(encoder) => encoder,
            None => {
                let mut encoder = Encoder::new(Vec::new(), width, height, &[]).map_err(|e| e.to_string())?;
                encoder.set_repeat(Repeat::Infinite).map_err(|e| e.to_string())?;
                self.encoder.insert(encoder)
            }
        };
        let mut colours = pixels.take();
        let frame = Frame { delay: self.delay, ..Frame::from_rgba_speed(width, height, &mut colours, SPEED) };
        encoder.write_frame(&frame).map_err(|e| e.to_string())
    }

    /// Returns the bytes of the file.
    ///
    /// # Errors
    /// If there are no drawings.
    pub fn finish(self) -> Result<Vec<u8>, String> {
        let encoder = self.encoder.ok_or("the run has no frames")?;
        encoder.into_inner().map_err(|e| e.to_string())
    }
}
