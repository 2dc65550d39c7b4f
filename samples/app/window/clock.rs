//! The sample's time in a window: the clock's, or a fixed step; and the pace of the frames.

use std::time::{Duration, Instant};

/// How often the title's numbers change: readable, yet quick enough to follow a key.
const REPORT_EVERY: Duration = Duration::from_millis(500);

/// Time that can be paused.
pub struct Clock {
    /// Seconds per frame; absent where the clock on the wall decides.
    step: Option<f64>,
    /// The same while frames are kept: an animation has its own pace, however long each frame takes.
    kept: Option<f64>,
    time: f64,
    last: Option<Instant>,
    paused: bool,
}

impl Clock {
    /// Starts at time 0 with the first frame.
    pub fn new(step: Option<f64>) -> Clock {
        Clock { step, kept: None, time: 0.0, last: None, paused: false }
    }

    /// The time of a frame that is drawn now.
    pub fn tick(&mut self, now: Instant) -> f64 {
        if let (false, Some(last)) = (self.paused, self.last) {
            self.time += self.step.or(self.kept).unwrap_or_else(|| (now - last).as_secs_f64());
        }
        self.last = Some(now);
        self.time
    }

    /// The time of the last frame.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Stops the time, or lets it go on.
    pub fn toggle_pause(&mut self) {
        self.paused = !self.paused;
        // The pause itself is no time: the next tick only marks where it ended.
        self.last = None;
    }

    /// So much time from frame to frame, where nothing else says how much, or as before.
    pub fn keep_to(&mut self, step: Option<f64>) {
        self.kept = step;
    }

    /// The window could not draw for a while; that is no time either.
    pub fn skip(&mut self) {
        self.last = None;
    }

    /// Whether the time stands still.
    pub fn paused(&self) -> bool {
        self.paused
    }
}

/// Mean time between frames over the last half second.
#[derive(Default)]
pub struct Pace {
    since: Option<Instant>,
    frames: u32,
}

impl Pace {
    /// Counts a frame; now and then returns the mean milliseconds per frame.
    pub fn frame(&mut self, now: Instant) -> Option<f64> {
        let since = *self.since.get_or_insert(now);
        let elapsed = now - since;
        if elapsed < REPORT_EVERY {
            self.frames += 1;
            return None;
        }
        let mean = elapsed.as_secs_f64() * 1000.0 / f64::from(self.frames.max(1));
        (self.since, self.frames) = (Some(now), 1);
        Some(mean)
    }

    /// Forgets the frames so far: the window stood still on purpose.
    pub fn reset(&mut self) {
        *self = Pace::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_is_no_time() {
        let (start, second) = (Instant::now(), Duration::from_secs(1));
        let mut clock = Clock::new(None);
        assert_eq!(clock.tick(start), 0.0);
        assert_eq!(clock.tick(start + second), 1.0);
        clock.toggle_pause();
        assert_eq!(clock.tick(start + 5 * second), 1.0);
        clock.toggle_pause();
        assert_eq!(clock.tick(start + 9 * second), 1.0);
        assert_eq!(clock.tick(start + 10 * second), 2.0);
    }

    #[test]
    fn a_step_counts_frames_not_seconds() {
        let mut clock = Clock::new(Some(0.25));
        let times: Vec<f64> = (0..3).map(|_| clock.tick(Instant::now())).collect();
        assert_eq!(times, [0.0, 0.25, 0.5]);
    }

    #[test]
    fn frames_that_are_kept_have_a_step_unless_the_user_has_one() {
        for (own, expected) in [(None, [0.0, 0.5, 1.0]), (Some(0.25), [0.0, 0.25, 0.5])] {
            let mut clock = Clock::new(own);
            clock.keep_to(Some(0.5));
            let times: Vec<f64> = (0..3).map(|_| clock.tick(Instant::now())).collect();
            assert_eq!(times, expected);
        }
    }

    #[test]
    fn the_pace_is_the_mean_of_half_a_second() {
        let (start, mut pace) = (Instant::now(), Pace::default());
        let reports: Vec<f64> = (0..=50).filter_map(|i| pace.frame(start + i * Duration::from_millis(20))).collect();
        assert_eq!(reports.len(), 2);
        assert!(reports.iter().all(|ms| (ms - 20.0).abs() < 1e-9), "{reports:?}");
    }
}
