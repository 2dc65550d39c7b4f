//! The account of a plan: each thing that a scene might need, whether it does, and why.

use serde::Serialize;

/// Whether something is needed, and why.
#[derive(Clone, Debug)]
pub enum Need {
    /// The picture changes without it, or the settings ask for it.
    Yes(String),
    /// It would be in the way of nothing, and change nothing: left out, unless [`crate::settings::Settings::keep_all`].
    Idle(String),
    /// There is nothing to keep.
    No(String),
}

impl Need {
    /// Needed, or idle.
    pub fn when(needed: bool, why: impl Into<String>, why_not: impl Into<String>) -> Need {
        if needed { Need::Yes(why.into()) } else { Need::Idle(why_not.into()) }
    }

    /// Asked for, or nothing to keep.
    pub fn asked(asked: bool, why: impl Into<String>, why_not: impl Into<String>) -> Need {
        if asked { Need::Yes(why.into()) } else { Need::No(why_not.into()) }
    }
}

/// One entry.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Decision {
    /// What would have it: "scene", or a mesh's primitive, a material, an image by its name.
    pub of: String,
    /// The thing.
    pub what: &'static str,
    /// Whether it is created.
    pub kept: bool,
    /// Why it is, or is not.
    pub why: String,
}

/// Everything that was decided.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    keep_all: bool,
    decisions: Vec<Decision>,
}

impl Ledger {
    /// An empty one. keep_all: what is idle is kept.
    pub fn new(keep_all: bool) -> Self {
        Ledger { keep_all, decisions: Vec::new() }
    }

    /// Whether what is idle is kept.
    pub fn keeps_all(&self) -> bool {
        self.keep_all
    }

    /// Takes a need down, and answers whether the thing is created.
    pub fn decide(&mut self, of: impl Into<String>, what: &'static str, need: Need) -> bool {
        let (kept, why) = match need {
            Need::Yes(why) => (true, why),
            Need::No(why) => (false, why),
            Need::Idle(why) if self.keep_all => (true, format!("kept by --keep-all, though {why}")),
            Need::Idle(why) => (false, why),
        };
        let decision = Decision { of: of.into(), what, kept, why };
        // A primitive of many instances is asked for once for each.
        if !self.decisions.contains(&decision) {
            self.decisions.push(decision);
        }
        kept
    }

    /// The entries, in the order they were made.
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// How a thing of something was decided; none where nobody asked.
    pub fn find(&self, of: &str, what: &str) -> Option<&Decision> {
        self.decisions.iter().find(|decision| decision.of == of && decision.what == what)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_idle_is_kept_on_request_and_what_is_not_there_never() {
        for keep_all in [false, true] {
            let mut ledger = Ledger::new(keep_all);
            assert!(ledger.decide("scene", "light", Need::Yes("it shines".into())));
            assert_eq!(ledger.decide("scene", "mirror", Need::Idle("nobody looks".into())), keep_all);
            assert!(!ledger.decide("scene", "door", Need::No("there is none".into())));
            assert!(ledger.decide("scene", "light", Need::Yes("it shines".into())));
            assert_eq!(ledger.decisions().len(), 3, "the same is told once");
            assert_eq!(ledger.find("scene", "mirror").map(|decision| decision.kept), Some(keep_all));
        }
    }
}
