//! Entropy coding of residuals: range variant of asymmetric numeral systems (Duda 2013), four states in turn, 16-bit
//! words, static tables of 1024 slots, one for each context.
//!
//! A state lies in 2^15 .. 2^31, so that it is a small integer in any language.

use super::predict::{Basis, TAPS, Taps, predict_in_space, predict_row};
use super::residual::{CONTEXTS, ESCAPE, MAX_SHIFT, Residuals, context_of, floor, index_of};
use crate::wire::TILE;

const SLOT_BITS: u32 = 10;
const SLOTS: usize = 1 << SLOT_BITS;
/// States: as many samples are under way at once.
const LANES: usize = 4;
/// The least a state may be between two samples.
const LEAST: u32 = 1 << 15;
/// Fixed part of a coded plane, beside its taps.
const HEAD_BYTES: usize = 28;

/// Why bytes are no coded plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damaged(pub &'static str);

/// How often each symbol comes, of 1024; the index is the symbol plus 128.
type Frequencies = [u16; 256];

/// Appends a coded plane: lengths, states, tables, words, escapes; padded to 4 bytes.
pub fn encode(residuals: &Residuals, out: &mut Vec<u8>) {
    let tables = frequencies(residuals);
    let (states, words) = code(residuals, &coder(&tables));
    let begin = out.len();
    out.extend([residuals.contexts as u8, residuals.shift, 0, 0]);
    out.extend((words.len() as u32).to_le_bytes());
    out.extend((residuals.escapes.len() as u32).to_le_bytes());
    states.iter().for_each(|state| out.extend(state.to_le_bytes()));
    debug_assert_eq!(out.len() - begin, HEAD_BYTES);
    tables.iter().for_each(|table| write_table(table, out));
    if (out.len() - begin) % 2 == 1 {
        out.push(0);
    }
    let table_bytes = (out.len() - begin - HEAD_BYTES) as u16;
    out[begin + 2..begin + 4].copy_from_slice(&table_bytes.to_le_bytes());
    // Written from the last sample to the first, read from the first to the last.
    out.extend(words.iter().rev().flat_map(|word| word.to_le_bytes()));
    out.extend(residuals.escapes.iter().flat_map(|count| count.to_le_bytes()));
    if (out.len() - begin) % 4 == 2 {
        out.extend([0, 0]);
    }
}

fn frequencies(residuals: &Residuals) -> Vec<Frequencies> {
    // Two, in turn: the same symbol often comes twice, and the second would wait for the first.
    let mut seen = [[0u32; 256 * CONTEXTS]; 2];
    for pair in residuals.keys.as_chunks::<2>().0 {
        (0..2).for_each(|i| seen[i][usize::from(pair[i]) % (256 * CONTEXTS)] += 1);
    }
    let [a, b] = seen;
    let both = |context: usize| std::array::from_fn(|i| a[context * 256 + i] + b[context * 256 + i]);
    (0..residuals.contexts).map(|context| normalise(both(context))).collect()
}

/// Shares out the slots: at least one for each symbol that comes, and exactly all of them.
fn normalise(seen: [u32; 256]) -> Frequencies {
    let total: u64 = seen.iter().map(|n| u64::from(*n)).sum();
    let mut table = [0u16; 256];
    if total == 0 {
        table[usize::from(index_of(0))] = SLOTS as u16;
        return table;
    }
    for (slots, n) in table.iter_mut().zip(seen) {
        let share = (u64::from(n) * SLOTS as u64 + total / 2) / total;
        *slots = if n == 0 { 0 } else { share.max(1) as u16 };
    }
    let mut left = SLOTS as i32 - table.iter().map(|slots| i32::from(*slots)).sum::<i32>();
    // A slot more or less is least felt by the most frequent.
    while left != 0 {
        let most = (0..256).max_by_key(|i| table[*i]).unwrap_or_default();
        let step = if left > 0 { left } else { left.max(1 - i32::from(table[most]) / 2).min(-1) };
        table[most] = (i32::from(table[most]) + step) as u16;
        left -= step;
    }
    table
}

/// A table: its first symbol, how many follow, and their slots, seven bits a byte.
fn write_table(table: &Frequencies, out: &mut Vec<u8>) {
    let first = table.iter().position(|slots| *slots > 0).unwrap_or_default();
    let last = table.iter().rposition(|slots| *slots > 0).unwrap_or_default();
    out.extend([first as u8, (last - first) as u8]);
    for slots in &table[first..=last] {
        if *slots < 128 {
            out.push(*slots as u8);
        } else {
            out.extend([0x80 | (slots & 127) as u8, (slots >> 7) as u8]);
        }
    }
}

/// What coding a symbol takes: division by its slots as a product with their reciprocal.
#[derive(Clone, Copy, Debug, Default)]
struct Coded {
    most: u32,
    reciprocal: u32,
    shift: u32,
    slots: u16,
    start: u16,
}

/// By context and symbol.
type Coder = [Coded; 256 * CONTEXTS];

fn coder(tables: &[Frequencies]) -> Box<Coder> {
    let mut coder = Box::new([Coded::default(); 256 * CONTEXTS]);
    for (table, coder) in tables.iter().zip(coder.chunks_exact_mut(256)) {
        let mut start = 0;
        for (slots, coded) in table.iter().zip(coder).filter(|(slots, _)| **slots > 0) {
            let wide = u32::from(*slots);
            let shift = 31 + wide.next_power_of_two().trailing_zeros();
            let reciprocal = (1u64 << shift).div_ceil(u64::from(wide)) as u32;
            *coded = Coded { most: wide << (31 - SLOT_BITS), reciprocal, shift, slots: *slots, start };
            start += slots;
        }
    }
    coder
}

fn code(residuals: &Residuals, coder: &Coder) -> ([u32; LANES], Vec<u16>) {
    let mut states = [LEAST; LANES];
    let mut words = Words16::with_capacity(residuals.keys.len() * (1 + usize::from(residuals.shift > 0)));
    let put = |state: u32, key: u16, words: &mut Words16| {
        let symbol = &coder[usize::from(key) % (256 * CONTEXTS)];
        let state = words.spill(state, symbol.most);
        let whole = ((u64::from(state) * u64::from(symbol.reciprocal)) >> symbol.shift) as u32;
        (whole << SLOT_BITS) + (state - whole * u32::from(symbol.slots)) + u32::from(symbol.start)
    };
    let groups = residuals.keys.as_chunks::<LANES>().0.iter();
    if residuals.shift == 0 {
        for keys in groups.rev() {
            for lane in (0..LANES).rev() {
                states[lane] = put(states[lane], keys[lane], &mut words);
            }
        }
    } else {
        let shift = u32::from(residuals.shift);
        let low = residuals.low.as_chunks::<LANES>().0.iter();
        for (keys, low) in groups.zip(low).rev() {
            for lane in (0..LANES).rev() {
                let state = words.spill(states[lane], 1 << (31 - shift)) << shift | u32::from(low[lane]);
                states[lane] = put(state, keys[lane], &mut words);
            }
        }
    }
    (states, words.taken())
}

/// Words in the order in which they are written; room for all is there from the beginning.
struct Words16 {
    words: Vec<u16>,
    count: usize,
}

impl Words16 {
    fn with_capacity(most: usize) -> Self {
        Self { words: vec![0; most], count: 0 }
    }

    /// The state, made smaller by a word where it is not below `most`.
    #[inline(always)]
    fn spill(&mut self, state: u32, most: u32) -> u32 {
        let full = state >= most;
        // Written in any case, and counted only where it is one: no branch that can't be foreseen.
        if let Some(word) = self.words.get_mut(self.count) {
            *word = state as u16;
        }
        self.count += usize::from(full);
        if full { state >> 16 } else { state }
    }

    fn taken(mut self) -> Vec<u16> {
        self.words.truncate(self.count);
        self.words
    }
}

/// A slot: its symbol in the upper 8 bits, the symbol's slots less one, and the slot's place among them.
type Slots = [u32; CONTEXTS * SLOTS];

/// Decodes planes; keeps its tables, so that none is allocated for each.
#[derive(Debug)]
pub struct PlaneDecoder {
    slots: Box<Slots>,
}

impl Default for PlaneDecoder {
    fn default() -> Self {
        Self { slots: Box::new([0; CONTEXTS * SLOTS]) }
    }
}

struct Words<'a> {
    words: &'a [[u8; 2]],
    next: usize,
}

impl Words<'_> {
    /// The state after a sample, with more bits where it needs them.
    #[inline(always)]
    fn refill(&mut self, state: u32) -> u32 {
        let short = state < LEAST;
        // Read in any case, and taken only where it is needed: no branch that can't be foreseen.
        let word = self.words.get(self.next).copied().unwrap_or_default();
        self.next += usize::from(short);
        if short { state << 16 | u32::from(u16::from_le_bytes(word)) } else { state }
    }
}

impl PlaneDecoder {
    /// Reads a coded plane from the front of `bytes` into `counts`, n x n, and returns how many bytes it took.
    ///
    /// # Errors
    /// [`Damaged`] for bytes that are no coded plane. What `counts` then holds is of no use.
    pub fn decode(
        &mut self,
        bytes: &[u8],
        basis: Basis,
        taps: Taps,
        n: usize,
        counts: &mut [i16],
    ) -> Result<usize, Damaged> {
        let (head, rest) = bytes.split_at_checked(HEAD_BYTES).ok_or(Damaged("too short"))?;
        let u32_at = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (contexts, shift) = (usize::from(head[0]), head[1]);
        let tables = usize::from(u16::from_le_bytes([head[2], head[3]]));
        let (words, escapes) = (u32_at(4) as usize, u32_at(8) as usize);
        if !matches!(contexts, 1 | CONTEXTS) || shift > MAX_SHIFT || (shift > 0 && contexts > 1) || tables % 2 == 1 {
            return Err(Damaged("a plane's head"));
        }
        if words > 2 * n * n || escapes > n * n {
            return Err(Damaged("more than the samples can take"));
        }
        let (tables, rest) = rest.split_at_checked(tables).ok_or(Damaged("too short"))?;
        let (words, rest) = rest.split_at_checked(words * 2).ok_or(Damaged("too short"))?;
        let (escapes, rest) = rest.split_at_checked(escapes * 2).ok_or(Damaged("too short"))?;
        let used = bytes.len() - rest.len();
        let padding = used.next_multiple_of(4) - used;
        if rest.get(..padding).is_none_or(|padding| padding.iter().any(|byte| *byte != 0)) {
            return Err(Damaged("padding"));
        }
        let mut left = tables;
        for table in self.slots.as_chunks_mut::<SLOTS>().0.iter_mut().take(contexts) {
            read_table(&mut left, table)?;
        }
        if left.len() > 1 || left.iter().any(|byte| *byte != 0) {
            return Err(Damaged("bytes after the tables"));
        }
        let mut states: [u32; LANES] = std::array::from_fn(|lane| u32_at(12 + 4 * lane));
        if states.iter().any(|state| !(LEAST..1 << 31).contains(state)) {
            return Err(Damaged("a state"));
        }
        let mut words = Words { words: words.as_chunks::<2>().0, next: 0 };
        let mut escapes = escapes.as_chunks::<2>().0.iter();
        let masked = if contexts > 1 { CONTEXTS - 1 } else { 0 };
        let mut row = [0i32; TILE];
        for z in 0..n {
            if let Basis::Space = basis {
                for x in 0..n {
                    let predicted = predict_in_space(counts, taps, n, z, x);
                    let state = &mut states[x % LANES];
                    let (residual, escaped) = self.next(state, predicted, masked, shift, &mut words);
                    counts[z * n + x] = (floor(predicted) + residual) as i16;
                    if escaped {
                        counts[z * n + x] = escape(&mut escapes)?;
                    }
                }
                continue;
            }
            predict_row(basis, taps, n, z, &mut row[..n]);
            let out = &mut counts[z * n..][..n];
            let groups = out.as_chunks_mut::<LANES>().0.iter_mut().zip(row.as_chunks::<LANES>().0);
            for (out, predicted) in groups {
                let mut any = 0;
                for lane in 0..LANES {
                    let (residual, escaped) = self.next(&mut states[lane], predicted[lane], masked, shift, &mut words);
                    out[lane] = (floor(predicted[lane]) + residual) as i16;
                    any |= u8::from(escaped) << lane;
                }
                if any != 0 {
                    for lane in (0..LANES).filter(|lane| any >> lane & 1 == 1) {
                        out[lane] = escape(&mut escapes)?;
                    }
                }
            }
        }
        // An encoder begins with the least state, so that is where a whole plane ends.
        if words.next != words.words.len() || escapes.next().is_some() || states != [LEAST; LANES] {
            return Err(Damaged("a plane does not end where it should"));
        }
        Ok(used + padding)
    }

    /// The residual of one sample, and whether it is an escape.
    #[inline(always)]
    fn next(&self, state: &mut u32, predicted: i32, masked: usize, shift: u8, words: &mut Words) -> (i32, bool) {
        let context = context_of(predicted) & masked;
        let slot = self.slots[context << SLOT_BITS | (*state as usize & (SLOTS - 1))];
        let symbol = slot as i32 >> 24;
        let share = (slot >> 12 & 0xfff) + 1;
        let mut next = words.refill(share * (*state >> SLOT_BITS) + (slot & 0xfff));
        let mut residual = symbol;
        if shift > 0 {
            residual = symbol << shift | (next & ((1 << shift) - 1)) as i32;
            next = words.refill(next >> shift);
        }
        *state = next;
        (residual, symbol == i32::from(ESCAPE))
    }
}

/// Reads the taps of a plane from the front of `bytes`, and whether its residuals have two bytes, as only deflate's may.
///
/// # Errors
/// [`Damaged`] for bytes that are none.
pub fn read_taps(bytes: &mut &[u8]) -> Result<(Taps, bool), Damaged> {
    let (head, rest) = bytes.split_at_checked(2 * TAPS + 4).ok_or(Damaged("too short"))?;
    *bytes = rest;
    let taps = Taps(std::array::from_fn(|i| i16::from_le_bytes([head[2 * i], head[2 * i + 1]])));
    match head[2 * TAPS..] {
        [wide @ 0..=1, 0, 0, 0] => Ok((taps, wide == 1)),
        _ => Err(Damaged("bytes after the taps")),
    }
}

fn escape(escapes: &mut std::slice::Iter<[u8; 2]>) -> Result<i16, Damaged> {
    escapes.next().map(|bytes| i16::from_le_bytes(*bytes)).ok_or(Damaged("fewer escapes than needed"))
}

fn read_table(bytes: &mut &[u8], table: &mut [u32; SLOTS]) -> Result<(), Damaged> {
    let mut byte = || {
        let (first, rest) = bytes.split_first().ok_or(Damaged("a table ends early"))?;
        *bytes = rest;
        Ok(u32::from(*first))
    };
    let (first, more) = (byte()?, byte()?);
    let mut filled = 0;
    for symbol in first..=first + more {
        let mut slots = byte()?;
        if slots >= 128 {
            slots = slots & 127 | byte()? << 7;
        }
        if symbol > 255 || filled + slots as usize > SLOTS {
            return Err(Damaged("a table with too much in it"));
        }
        if slots > 0 {
            let entry = (symbol ^ 0x80) << 24 | (slots - 1) << 12;
            for (place, slot) in table[filled..filled + slots as usize].iter_mut().enumerate() {
                *slot = entry | place as u32;
            }
        }
        filled += slots as usize;
    }
    if filled == SLOTS { Ok(()) } else { Err(Damaged("a table with too little in it")) }
}
