//! Memory that is taken and given back by number.

/// Slabs in use; those given back are empty, and their numbers are given out again.
pub struct Slabs<T> {
    slabs: Vec<Vec<T>>,
    free: Vec<usize>,
}

impl<T> Default for Slabs<T> {
    fn default() -> Self {
        Self { slabs: Vec::new(), free: Vec::new() }
    }
}

impl<T: Clone + Default> Slabs<T> {
    /// The number of a slab of so many zeros.
    pub fn take(&mut self, len: usize) -> usize {
        let slab = vec![T::default(); len];
        match self.free.pop() {
            Some(name) => {
                self.slabs[name] = slab;
                name
            }
            None => {
                self.slabs.push(slab);
                self.slabs.len() - 1
            }
        }
    }

    pub fn get(&self, name: usize) -> &[T] {
        &self.slabs[name]
    }

    pub fn get_mut(&mut self, name: usize) -> &mut Vec<T> {
        &mut self.slabs[name]
    }

    pub fn give(&mut self, name: usize) {
        self.slabs[name] = Vec::new();
        self.free.push(name);
    }
}
