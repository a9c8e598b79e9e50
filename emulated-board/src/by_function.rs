//! Where the instructions of a control tick go, by function of the image.
//!
//! What the compiler has inlined counts for the function that it stands in.

use std::collections::BTreeMap;
use std::path::Path;

use object::{Object, ObjectSymbol, SymbolKind};
use rigless::emulator::{Hit, Watch};

/// What one function costs a control tick.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionCost {
    /// Its path in the source.
    pub name: String,
    /// Instructions a tick, the mean.
    pub mean: f64,
    /// Instructions in the tick that took most.
    pub worst: u64,
}

/// Instructions by function, in the ticks between two instants.
#[derive(Debug, Default)]
pub(crate) struct ByFunction {
    /// Functions by their first address: name, and the address after the last one.
    functions: BTreeMap<u64, (String, u64)>,
    counts: BTreeMap<u64, u64>,
    /// Of this tick.
    tick: BTreeMap<u64, u64>,
    /// Of the tick with most.
    worst: BTreeMap<u64, u64>,
    /// Since the handler's latest instruction: of this tick if another one follows, else behind its end.
    since: BTreeMap<u64, u64>,
    interrupt: u64,
    ticks: u64,
}

impl ByFunction {
    /// A counter for this image, and the watches that it needs: every instruction.
    pub fn new(image: &Path) -> Result<(Self, Vec<Watch>), Box<dyn std::error::Error>> {
        let bytes = std::fs::read(image)?;
        let file = object::File::parse(&*bytes)?;
        let mut new = Self::default();
        for symbol in file.symbols().filter(|s| s.kind() == SymbolKind::Text && s.size() > 0) {
            // The lowest bit marks Thumb code.
            let (start, name) = (symbol.address() & !1, symbol.name()?);
            new.functions.insert(start, (readable(name), start + symbol.size()));
            if name == "TIM2" {
                new.interrupt = start;
            }
        }
        let code = new.functions.iter().flat_map(|(start, (_, end))| (*start..*end).step_by(2));
        let watches = code.map(Watch::Instruction).collect();
        Ok((new, watches))
    }

    pub fn on_hit(&mut self, hit: &Hit) {
        let Some((&start, &(_, end))) = self.functions.range(..=hit.address).next_back() else {
            return;
        };
        if hit.address >= end {
            return;
        }
        if hit.address == self.interrupt {
            self.since.clear();
            self.finish();
        }
        if start == self.interrupt {
            for (function, count) in std::mem::take(&mut self.since) {
                *self.tick.entry(function).or_default() += count;
            }
            *self.tick.entry(start).or_default() += 1;
        } else {
            *self.since.entry(start).or_default() += 1;
        }
    }

    /// A tick is over when the next one begins.
    fn finish(&mut self) {
        let tick = std::mem::take(&mut self.tick);
        for (function, count) in &tick {
            *self.counts.entry(*function).or_default() += count;
        }
        self.ticks += 1;
        if tick.values().sum::<u64>() > self.worst.values().sum::<u64>() {
            self.worst = tick;
        }
    }

    /// Every function, most instructions first.
    pub fn table(mut self) -> Vec<FunctionCost> {
        self.finish();
        let ticks = self.ticks as f64;
        let mut table: Vec<_> = self
            .counts
            .iter()
            .map(|(start, count)| FunctionCost {
                name: self.functions[start].0.clone(),
                mean: *count as f64 / ticks,
                worst: self.worst.get(start).copied().unwrap_or(0),
            })
            .collect();
        table.sort_by(|a, b| b.mean.total_cmp(&a.mean));
        table
    }
}

/// The parts of a mangled name, without hashes and generics: `control::profile::Profile::step`.
fn readable(mangled: &str) -> String {
    let mut parts = Vec::new();
    let mut rest = mangled;
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit()) {
        rest = &rest[at..];
        let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        let len: usize = rest[..digits].parse().unwrap_or(0);
        let name = rest[digits..].get(..len).unwrap_or("").trim_start_matches('_');
        rest = rest.get(digits + len..).unwrap_or("");
        let hash = name.len() == 17 && name.starts_with('h');
        if !name.is_empty() && !hash && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        {
            parts.push(name);
        }
    }
    if parts.is_empty() { mangled.to_string() } else { parts.join("::") }
}

#[cfg(test)]
mod tests {
    use super::readable;

    #[test]
    fn names_can_be_read() {
        let name = "_ZN7control7profile7Profile4step17h0123456789abcdefE";
        assert_eq!(readable(name), "control::profile::Profile::step");
        assert_eq!(readable("TIM2"), "TIM2");
    }
}
