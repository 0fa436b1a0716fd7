//! The size of a picture, and why there is none.

use thiserror::Error;
use underbrush_recording::Fault;
use underbrush_sim::scene::limits::PICTURE_PX;

/// Why a picture cannot be drawn.
#[derive(Debug, Error)]
pub enum RenderError {
    /// The size is not allowed.
    #[error("{} x {} pixels; allowed: {PICTURE_PX} in each direction; choose such a size", .0.width, .0.height)]
    Size(Size),
    /// The camera sees nothing, or it is not said which way is up.
    #[error(
        "camera: found {0}; allowed: numbers up to 1000 m, eye and target 1 mm apart, another direction for up than the line \
         between them, and a field of view of 1 to 150 degrees; move the camera"
    )]
    Camera(String),
    /// The camera is carried by a link that is not known.
    #[error("camera: found the link {link:?}; allowed: {links}; name one of them")]
    Link {
        /// The link.
        link: String,
        /// The links that are known.
        links: String,
    },
    /// There are no shapes, as in a robot's log or a table of trials, or no frames.
    #[error(
        "no shapes of an arm or no frames are known, so there is nothing to draw; a robot's log has no arm: look at it on the page \
         (underbrush replay --out)"
    )]
    NoBodies,
    /// The file cannot be encoded or written.
    #[error("the picture cannot be written: {0}")]
    Encoding(String),
}

impl From<RenderError> for Fault {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Encoding(_) => Fault::Run(error.to_string()),
            other => Fault::Usage(other.to_string()),
        }
    }
}

/// Width and height of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Width.
    pub width: usize,
    /// Height.
    pub height: usize,
}

impl Size {
    /// Demands 64 to 1280 pixels in each direction.
    ///
    /// # Errors
    /// [`RenderError::Size`].
    pub fn check(self) -> Result<Self, RenderError> {
        let fits = [self.width, self.height].iter().all(|side| PICTURE_PX.hold(*side as f64));
        if fits { Ok(self) } else { Err(RenderError::Size(self)) }
    }

    /// Width over height.
    pub fn aspect(self) -> f64 {
        self.width as f64 / self.height as f64
    }
}
