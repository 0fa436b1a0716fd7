//! Pictures and films as files.

use color_quant::NeuQuant;
use gif::{Encoder, Frame, Repeat};
use rayon::prelude::*;
use underbrush_recording::Recording;

use crate::{Camera, RenderError, Size, Stage};

/// Pictures that are drawn before they are written: some for each core, few enough to hold them.
const AT_ONCE: usize = 16;
/// The palette is chosen from about this many pictures, evenly spaced.
const TYPICAL: usize = 6;
/// Of these pictures, every n-th pixel is looked at. `color_quant` calls 10 a good balance of time and quality.
const EVERY: i32 = 10;
/// Colours of the palette.
const COLOURS: usize = 255;
/// Stands for a pixel that has not changed since the picture before: the number after the last colour.
const UNCHANGED: u8 = 255;
/// A colour is looked up by this many leading bits of each channel.
const BITS: u32 = 6;

/// How a reach becomes a film.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    /// Width and height.
    pub size: Size,
    /// Hundredths of a second for which a picture is shown; 1 or more.
    pub delay: u16,
    /// How many times as fast as in reality it plays; positive.
    pub speed: f64,
}

impl Film {
    /// Pictures per second if nothing else is said. They fall on frames at 100 Hz, and on the hundredths of a second of GIFs.
    pub const FPS: u16 = 25;

    /// The frames that it shows.
    pub fn frames(&self, recording: &Recording) -> Vec<usize> {
        // Not zero, so that there is an end.
        let step = (0.01 * f64::from(self.delay) * self.speed * recording.rate_hz).max(1e-3);
        let numbers = (0..).map(|picture| (f64::from(picture) * step).round() as usize);
        numbers.take_while(|number| *number < recording.frames.len()).collect()
    }

    /// Draws a reach as a GIF that plays in a loop, seen from the camera that `camera` gives for each frame, on the threads of the
    /// current rayon pool. Calls `drawn` with the number of further pictures whenever some are done. All pictures share one palette,
    /// so that nothing flickers, and hold only what has changed.
    ///
    /// # Errors
    /// All of [`RenderError`].
    pub fn draw(
        &self,
        recording: &Recording,
        stage: &Stage,
        camera: impl Fn(u32) -> Result<Camera, RenderError> + Sync,
        drawn: impl Fn(usize),
    ) -> Result<Vec<u8>, RenderError> {
        let numbers = self.frames(recording);
        let draw = |number: &usize| {
            let moment = stage.moment(*number as u32, &recording.frames[*number]);
            moment.rgb(&camera(*number as u32)?, self.size)
        };
        let typical = numbers.iter().step_by(numbers.len() / TYPICAL + 1).map(draw);
        let typical = typical.collect::<Result<Vec<_>, _>>()?.concat();
        let pixels: Vec<u8> = typical.chunks_exact(3).flat_map(opaque).collect();
        let palette = NeuQuant::new(EVERY, COLOURS, &pixels);
        // The place in the palette of each colour, once it has been found.
        let mut places: Vec<Option<u8>> = vec![None; 1 << (3 * BITS)];
        let mut place = |pixel: &[u8]| {
            let key = pixel.iter().fold(0, |key, channel| key << BITS | usize::from(channel >> (8 - BITS)));
            *places[key].get_or_insert_with(|| palette.index_of(&opaque(pixel)) as u8)
        };
        let (width, height) = (self.size.width as u16, self.size.height as u16);
        let mut encoder = Encoder::new(Vec::new(), width, height, &palette.color_map_rgb()).map_err(failed)?;
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
        let mut last: Vec<u8> = Vec::new();
        for some in numbers.chunks(AT_ONCE) {
            for picture in some.par_iter().map(draw).collect::<Vec<_>>() {
                let own: Vec<u8> = picture?.chunks_exact(3).map(&mut place).collect();
                let changed = |(pixel, own): (usize, &u8)| if last.get(pixel) == Some(own) { UNCHANGED } else { *own };
                let buffer = own.iter().enumerate().map(changed).collect();
                let (delay, transparent) = (self.delay, Some(UNCHANGED));
                let frame = Frame { width, height, buffer, delay, transparent, ..Frame::default() };
                encoder.write_frame(&frame).map_err(failed)?;
                last = own;
            }
            drawn(some.len());
        }
        encoder.into_inner().map_err(|error| RenderError::Encoding(error.to_string()))
    }
}

fn opaque(pixel: &[u8]) -> [u8; 4] {
    [pixel[0], pixel[1], pixel[2], u8::MAX]
}

fn failed(error: gif::EncodingError) -> RenderError {
    RenderError::Encoding(error.to_string())
}
