//! Ends work that takes minutes before it is done, and says what a panic that ended work was about.
//!
//! Such work calls [`check`] from time to time. A caller that may want to end it runs it on threads that [`listen`] to a flag.

use std::any::Any;
use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static FLAG: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// What [`check`] unwinds with.
#[derive(Clone, Copy, Debug)]
pub struct Stopped;

/// Work on this thread ends once the flag is set.
///
/// ```
/// use std::panic::catch_unwind;
/// use std::sync::Arc;
/// use std::sync::atomic::{AtomicBool, Ordering};
/// use underbrush_recording::stop::{Stopped, check, listen};
///
/// let flag = Arc::new(AtomicBool::new(false));
/// listen(Arc::clone(&flag));
/// assert!(catch_unwind(check).is_ok());
/// flag.store(true, Ordering::Relaxed);
/// assert!(catch_unwind(check).unwrap_err().is::<Stopped>());
/// ```
pub fn listen(flag: Arc<AtomicBool>) {
    FLAG.set(Some(flag));
}

/// Ends the work of this thread by unwinding with [`Stopped`], if it listens to a flag that is set.
pub fn check() {
    if FLAG.with_borrow(|flag| flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))) {
        resume_unwind(Box::new(Stopped));
    }
}

/// What a caught panic says, if it says anything.
///
/// ```
/// use underbrush_recording::stop::panic_text;
///
/// let caught = std::panic::catch_unwind(|| panic!("{} apples", 2)).unwrap_err();
/// assert_eq!(panic_text(caught.as_ref()), Some("2 apples"));
/// ```
pub fn panic_text(panic: &(dyn Any + Send)) -> Option<&str> {
    panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied())
}
