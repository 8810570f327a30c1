//! Limits of the model size, summed over all cards. A card that exceeds a limit is reported before memory is allocated.

use crate::deck::untrusted::{self, is_restricted};
use crate::platform::{MemoryLimit, memory_limit};

/// Items whose total number in a model is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BudgetedItem {
    Nodes,
    Elements,
    /// Entries in lists of nodes and elements, for example in sets.
    Members,
}

/// Name of each item, and the memory it needs from reading to running, in bytes.
const ITEMS: [(&str, u64); 3] = [("nodes", 200), ("elements", 700), ("entries in sets and lists", 16)];
/// Largest number of nodes, and of elements.
const MAX_COUNT: u128 = 20_000_000;
/// Largest number of list entries: a constant, plus a number per node and element.
const MAX_ENTRIES: [u128; 2] = [20_000_000, 40];

/// Items of the model that have been counted so far.
#[derive(Debug)]
pub(super) struct SizeBudget {
    members: u64,
    memory: MemoryLimit,
    pub reported: bool,
}

impl Default for SizeBudget {
    fn default() -> Self {
        let unknown = MemoryLimit { name: "the memory of the machine", bytes: u128::MAX };
        SizeBudget { members: 0, memory: memory_limit().unwrap_or(unknown), reported: false }
    }
}

impl SizeBudget {
    /// Counts `count` more items in a model with `mesh` nodes and elements.
    ///
    /// # Errors
    /// A message if a limit is exceeded; nothing is counted then.
    pub fn spend(&mut self, item: BudgetedItem, count: u128, mesh: [usize; 2]) -> Result<(), String> {
        let mut counts = [mesh[0] as u128, mesh[1] as u128, u128::from(self.members)];
        let largest = if is_restricted() { untrusted::MAX_COUNT } else { MAX_COUNT };
        let limit = if item == BudgetedItem::Members {
            MAX_ENTRIES[0] + MAX_ENTRIES[1] * (counts[0] + counts[1])
        } else {
            largest
        };
        let (name, total) = (ITEMS[item as usize].0, counts[item as usize].saturating_add(count));
        if total > limit {
            return Err(format!("{total} {name} in all cards up to this one; at most {limit} are allowed"));
        }
        counts[item as usize] = total;
        let bytes: u128 = counts.iter().zip(ITEMS).map(|(count, (_, bytes))| count * u128::from(bytes)).sum();
        if bytes > self.memory.bytes {
            return Err(format!(
                "{total} {name} in all cards up to this one: the deck needs about {:.1} GB, and {} is {:.1} GB",
                1e-9 * bytes as f64,
                self.memory.name,
                1e-9 * self.memory.bytes as f64
            ));
        }
        self.members = counts[2] as u64;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{BudgetedItem, MemoryLimit, SizeBudget};

    #[test]
    fn counts_and_bytes_are_bounded_over_all_cards() {
        let memory = MemoryLimit { name: "the limit", bytes: 1_000_000_000 };
        let mut budget = SizeBudget { members: 0, memory, reported: false };
        let mut spend = |item, count, mesh| budget.spend(item, count, mesh);
        assert_eq!(spend(BudgetedItem::Members, 20_000_040, [1, 0]), Ok(()));
        let message = spend(BudgetedItem::Members, 1, [1, 0]).expect_err("too many");
        assert!(message.contains("20000041 entries in sets and lists"), "{message}");
        assert!(spend(BudgetedItem::Nodes, u128::MAX, [1, 0]).is_err());
        // 0.3 GB of list entries and 0.8 GB of elements.
        let message = spend(BudgetedItem::Elements, 1_100_000, [0, 0]).expect_err("too many bytes");
        assert!(message.contains("about 1.1 GB, and the limit is 1.0 GB"), "{message}");
        assert_eq!(spend(BudgetedItem::Elements, 900_000, [0, 0]), Ok(()));
    }
}
