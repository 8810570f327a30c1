//! Disjoint sets of numbers, to find connected parts.

/// A partition of the numbers from 0 into sets, each with a representative.
#[derive(Clone, Debug)]
pub struct DisjointSets {
    /// Another member of the same set; a representative refers to itself.
    next: Vec<usize>,
}

impl DisjointSets {
    /// Creates sets of one number each.
    pub fn new(count: usize) -> DisjointSets {
        DisjointSets { next: (0..count).collect() }
    }

    /// Returns the representative of the set of a number, and shortens the path to it.
    pub fn representative(&mut self, mut number: usize) -> usize {
        while self.next[number] != number {
            self.next[number] = self.next[self.next[number]];
            number = self.next[number];
        }
        number
    }

    /// Unites the sets of two numbers; the representative is that of the first one.
    pub fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.representative(a), self.representative(b));
        self.next[b] = a;
    }
}

#[cfg(test)]
mod tests {
    use super::DisjointSets;

    #[test]
    fn united_numbers_have_one_representative() {
        let mut sets = DisjointSets::new(6);
        [(0, 1), (2, 3), (1, 3), (4, 4)].into_iter().for_each(|(a, b)| sets.unite(a, b));
        let representatives: Vec<usize> = (0..6).map(|number| sets.representative(number)).collect();
        assert_eq!(representatives, [0, 0, 0, 0, 4, 5]);
    }
}
