//! Results that several requests of one page ask for at once, or again at each zoom.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use hysteron_model::model::{Score, Signals};

/// A model on a record.
pub(crate) struct Simulated {
    /// Inputs and outputs.
    pub signals: Signals,
    /// The simulation and its scores.
    pub score: Score,
    /// Half width of the 95 % band of a new measurement, where the model file gives one; made when it is drawn.
    pub half_width: OnceLock<Option<Vec<f64>>>,
}

/// Results kept.
const KEPT: usize = 3;

/// A result that is being computed, or is there.
type Place<T> = Arc<Mutex<Option<Arc<T>>>>;

/// The last few results by their key, each computed once.
pub(crate) struct Remembered<T> {
    /// The one asked for last is at the end.
    kept: Mutex<Vec<(String, Place<T>)>>,
}

impl<T> Default for Remembered<T> {
    fn default() -> Self {
        Self { kept: Mutex::default() }
    }
}

impl<T> Remembered<T> {
    /// The result of `key`, made where it is not there; whoever asks meanwhile waits for it. An error is not
    /// kept.
    ///
    /// # Errors
    /// Those of `make`.
    pub(crate) fn get<E>(&self, key: String, make: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        let place = self.place(key);
        let mut held = place.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = held.as_ref() {
            return Ok(Arc::clone(found));
        }
        let made = Arc::new(make()?);
        *held = Some(Arc::clone(&made));
        Ok(made)
    }

    fn place(&self, key: String) -> Place<T> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let place = match kept.iter().position(|(known, _)| *known == key) {
            Some(at) => kept.remove(at).1,
            None => Place::default(),
        };
        kept.push((key, Arc::clone(&place)));
        if kept.len() > KEPT {
            kept.remove(0);
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_made_once_and_an_error_is_not_kept() {
        let remembered = Remembered::<u8>::default();
        assert_eq!(remembered.get("a".into(), || Err("no")), Err("no"));
        assert_eq!(*remembered.get("a".into(), || Ok::<_, ()>(1)).unwrap(), 1);
        assert_eq!(*remembered.get("a".into(), || Ok::<_, ()>(2)).unwrap(), 1);
        for other in ["b", "c", "d"] {
            assert_eq!(*remembered.get(other.into(), || Ok::<_, ()>(3)).unwrap(), 3);
        }
        assert_eq!(*remembered.get("a".into(), || Ok::<_, ()>(4)).unwrap(), 4, "the oldest one has gone");
    }
}
