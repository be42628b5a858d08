//! The body of an upload as it arrives: a client that falls silent or trickles does not hold a place for ever.

use std::time::{Duration, Instant};

use axum::body::Body;
use axum::http::StatusCode;
use http_body_util::BodyExt;
use tokio::time::timeout;

use crate::api::Problem;
use crate::refused::{Answer, Refused};

/// Longest silence within an upload.
const SILENCE: Duration = Duration::from_secs(30);
/// Least rate of an upload as a whole [bytes/s], after the silence that is allowed.
const LEAST_RATE: f64 = 1024.0;
/// Longest time that the rest of a refused upload is read for, so that its client hears the refusal.
const TO_THE_END: Duration = Duration::from_secs(5);

/// The body of an upload.
pub(super) struct Arriving {
    body: Body,
    begun: Instant,
    bytes: u64,
}

impl Arriving {
    pub(super) fn new(body: Body) -> Self {
        Self { body, begun: Instant::now(), bytes: 0 }
    }

    /// Adds the next bytes to `arrived`; false at the end.
    ///
    /// # Errors
    /// 408 for an upload that is too slow, 400 for one that breaks off.
    pub(super) async fn next(&mut self, arrived: &mut Vec<u8>) -> Answer<bool> {
        let patience = patience(self.begun.elapsed(), self.bytes);
        let frame = timeout(patience, self.body.frame()).await.map_err(|_| too_slow())?;
        let Some(frame) = frame else { return Ok(false) };
        let frame = frame.map_err(|e| Refused::bad(format!("the upload broke off: {e}")))?;
        if let Some(bytes) = frame.data_ref() {
            self.bytes += bytes.len() as u64;
            arrived.extend_from_slice(bytes);
        }
        Ok(true)
    }

    /// Reads on and drops what comes: a client that still sends would not read the refusal.
    pub(super) async fn discard(mut self) {
        let rest = async { while let Some(Ok(_)) = self.body.frame().await {} };
        let _ = timeout(TO_THE_END, rest).await;
    }
}

/// Time to wait for the next bytes.
fn patience(elapsed: Duration, bytes: u64) -> Duration {
    let whole = SILENCE.as_secs_f64() + bytes as f64 / LEAST_RATE;
    let left = whole - elapsed.as_secs_f64();
    Duration::try_from_secs_f64(left.max(0.0)).map_or(SILENCE, |left| left.min(SILENCE))
}

fn too_slow() -> Refused {
    let what = "the upload is too slow: nothing came for half a minute, or less than 1 kB/s";
    let remedy = "Send it again, or copy the file into the folder.";
    let problem = Problem { remedy: Some(remedy.to_owned()), ..Problem::new(what, None) };
    Refused::new(StatusCode::REQUEST_TIMEOUT, problem)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;

    #[test]
    fn silence_and_trickles_end_and_a_steady_upload_does_not() {
        assert_eq!(patience(Duration::ZERO, 0), SILENCE);
        assert_eq!(patience(Duration::from_secs(30), 0), Duration::ZERO);
        // A megabyte has bought a thousand seconds, but no longer silence.
        assert_eq!(patience(Duration::from_secs(60), 1 << 20), SILENCE);
        // A byte every second.
        assert!(patience(Duration::from_secs(29), 29) < Duration::from_millis(1100));
        assert_eq!(patience(Duration::from_secs(40), 40), Duration::ZERO);
    }

    #[test]
    fn a_silent_upload_is_refused_and_an_ended_one_is_not() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let mut ended = Arriving::new(Body::from("abc"));
            let mut bytes = Vec::new();
            while ended.next(&mut bytes).await.unwrap() {}
            assert_eq!(bytes, b"abc");
            let silent = Body::from_stream(futures_util::stream::pending::<std::io::Result<Vec<u8>>>());
            let mut silent = Arriving { begun: Instant::now() - SILENCE, ..Arriving::new(silent) };
            let problem = silent.next(&mut bytes).await.unwrap_err().into_problem();
            assert!(problem.what.contains("too slow"), "{problem:?}");
        });
    }
}
