//! Fits the models that may be asked for next, while nobody waits: those with one effect more or less than the last.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use super::request::{EffectRequest, ModelRequest};

/// Whether somebody waits for an answer is looked at this often.
const LOOKED_EVERY: Duration = Duration::from_millis(20);

/// What was asked last, and how many wait for an answer.
#[derive(Default)]
pub(super) struct LookAhead {
    last: Mutex<(u64, ModelRequest)>,
    asked: Condvar,
    waiting: AtomicUsize,
}

/// Somebody waits for as long as this lives.
pub(super) struct Waiting<'a>(&'a AtomicUsize);

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl LookAhead {
    /// Somebody waits from now on.
    pub(super) fn wait(&self) -> Waiting<'_> {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        Waiting(&self.waiting)
    }

    /// A model was asked for; one set by hand leads nowhere.
    pub(super) fn note(&self, request: &ModelRequest) {
        if request.values().is_none() {
            let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
            *last = (last.0 + 1, request.clone());
            self.asked.notify_all();
        }
    }

    /// Computes, for each model that is asked for, its neighbours: with each of the effects that `likely` gives, the likeliest
    /// first, or without one of its own, in the order of `catalogue`. Does not return.
    pub(super) fn run(
        &self,
        likely: impl Fn() -> Vec<String>,
        catalogue: impl Fn() -> Vec<String>,
        compute: impl Fn(&ModelRequest),
    ) {
        let mut seen = 0;
        loop {
            let (number, request) = self.next(seen);
            seen = number;
            for neighbour in neighbours(&request, &likely(), &catalogue()) {
                while self.waiting.load(Ordering::Relaxed) > 0 {
                    std::thread::sleep(LOOKED_EVERY);
                }
                if self.last.lock().unwrap_or_else(PoisonError::into_inner).0 != seen {
                    break;
                }
                compute(&neighbour);
            }
        }
    }

    /// The latest model that was asked for, once there is another than before.
    fn next(&self, seen: u64) -> (u64, ModelRequest) {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let last = self.asked.wait_while(last, |last| last.0 == seen);
        last.unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// With one effect more or less, as the page asks for them: in the order of the catalogue.
fn neighbours(request: &ModelRequest, ids: &[String], catalogue: &[String]) -> Vec<ModelRequest> {
    let rank = |effect: &EffectRequest| catalogue.iter().position(|id| *id == effect.id);
    let own: Vec<&str> = request.effects.iter().map(|effect| &*effect.id).collect();
    let fewer = own.iter().map(|left_out| {
        let kept = request.effects.iter().filter(|effect| effect.id != *left_out);
        ModelRequest { effects: kept.cloned().collect(), quick: false }
    });
    let more = ids.iter().filter(|id| !own.contains(&&***id)).map(|id| {
        let further = EffectRequest { id: id.clone(), values: None };
        let mut effects: Vec<_> = request.effects.iter().cloned().chain([further]).collect();
        effects.sort_by_key(rank);
        ModelRequest { effects, quick: false }
    });
    fewer.chain(more).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_have_one_effect_more_or_less() {
        let ids = ["a", "b", "c"].map(str::to_owned);
        let keys = |effects: &[&str]| {
            let catalogue = ["a", "b", "c", "own"].map(str::to_owned);
            let near = neighbours(&ModelRequest::fitted(effects), &ids, &catalogue);
            near.iter().map(ModelRequest::key).collect::<Vec<_>>()
        };
        assert_eq!(keys(&[]), ["a", "b", "c"]);
        assert_eq!(keys(&["b"]), ["", "a,b", "b,c"]);
        assert_eq!(keys(&["c", "own"]), ["own", "c", "a,c,own", "b,c,own"]);
    }

    #[test]
    fn what_is_asked_meanwhile_comes_first() {
        let ahead = LookAhead::default();
        let found = Mutex::new(Vec::new());
        let ids = || ["a", "b", "c"].map(str::to_owned).to_vec();
        let compute = |request: &ModelRequest| {
            let mut found = found.lock().unwrap();
            found.push(request.key());
            if found.len() == 1 {
                ahead.note(&ModelRequest::fitted(&["c"]));
            } else if found.len() == 4 {
                // The only way out of a loop without end.
                panic!("enough");
            }
        };
        std::thread::scope(|scope| {
            let runs = scope.spawn(|| ahead.run(ids, ids, compute));
            ahead.note(&ModelRequest::default());
            assert!(runs.join().is_err());
        });
        let found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
        assert_eq!(found, ["a", "", "a,c", "b,c"]);
    }
}
