//! What a deck may ask for, over all its cards: told with the card that asks for too much, before it is made.
//! Never here: what is made.

use crate::platform::memory_of_machine;

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Good {
    Nodes,
    Elements,
    /// Places in lists of nodes and elements, as sets and other cards name them.
    Members,
}

/// Names, and bytes that one takes from reading to running.
const GOODS: [(&str, u64); 3] = [("nodes", 200), ("elements", 700), ("places in sets and lists", 16)];
/// The most nodes, and the most elements.
const MOST: u128 = 20_000_000;
/// The most places: so many, and so many more for each node and element.
const PLACES: [u128; 2] = [20_000_000, 40];

/// What a deck has.
#[derive(Debug)]
pub(super) struct Budget {
    members: u64,
    /// Bytes of the machine.
    memory: u128,
    pub told: bool,
}

impl Default for Budget {
    fn default() -> Self {
        Budget { members: 0, memory: memory_of_machine().unwrap_or(u128::MAX), told: false }
    }
}

impl Budget {
    /// Whether so many more may be where there are these nodes and elements.
    ///
    /// # Errors
    /// What is too much.
    pub fn spend(&mut self, good: Good, count: u128, mesh: [usize; 2]) -> Result<(), String> {
        let mut all = [mesh[0] as u128, mesh[1] as u128, u128::from(self.members)];
        let most = if good == Good::Members { PLACES[0] + PLACES[1] * (all[0] + all[1]) } else { MOST };
        let (name, wanted) = (GOODS[good as usize].0, all[good as usize].saturating_add(count));
        if wanted > most {
            return Err(format!(
                "{wanted} {name} up to this card, over all cards; more than {most} are taken for a slip"
            ));
        }
        all[good as usize] = wanted;
        let bytes: u128 = all.iter().zip(GOODS).map(|(count, (_, bytes))| count * u128::from(bytes)).sum();
        if bytes > self.memory {
            return Err(format!(
                "{wanted} {name} up to this card: the deck needs about {:.1} GB, and the machine has {:.1}",
                1e-9 * bytes as f64,
                1e-9 * self.memory as f64
            ));
        }
        self.members = all[2] as u64;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Budget, Good};

    #[test]
    fn counts_and_bytes_are_bounded_over_all_cards() {
        let mut budget = Budget { members: 0, memory: 1_000_000_000, told: false };
        let mut spend = |good, count, mesh| budget.spend(good, count, mesh);
        assert_eq!(spend(Good::Members, 20_000_040, [1, 0]), Ok(()));
        let told = spend(Good::Members, 1, [1, 0]).expect_err("too many");
        assert!(told.contains("20000041 places in sets and lists"), "{told}");
        assert!(spend(Good::Nodes, u128::MAX, [1, 0]).is_err());
        // 0.3 GB of places, and 0.8 of elements.
        let told = spend(Good::Elements, 1_100_000, [0, 0]).expect_err("too many bytes");
        assert!(told.contains("about 1.1 GB, and the machine has 1.0"), "{told}");
        assert_eq!(spend(Good::Elements, 900_000, [0, 0]), Ok(()));
    }
}
