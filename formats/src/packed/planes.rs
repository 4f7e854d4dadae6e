//! Planes, packed: each value is expected to follow from those of the entries beside and above it.
//! What is left is coded with frequencies that depend on how much these differ.

use pocketnerf_core::encoding::planes::FEATURES;

use super::ans::{Frequencies, SymbolReader, TOTAL};

/// An entry's values, in steps.
pub(crate) type Entry = [u8; FEATURES];

/// How uncertain a value may be; the last where neighbours are missing.
pub(crate) const CLASSES: usize = 4;
/// Which of the neighbours hold something.
pub(crate) const CONTEXTS: usize = 16;
/// The code of a value that is as expected. Few differences near it take few frequencies.
pub(crate) const AS_EXPECTED: u8 = 128;

/// The entries before one: beside it, above, above the one beside it, and above the one behind it.
/// Those that hold nothing count as missing.
pub(crate) struct Around([Option<Entry>; 4]);

/// What an entry's values are expected to be, and how much their neighbours differ; `None` where
/// one is missing.
pub(crate) struct Expected {
    pub(crate) values: [i8; FEATURES],
    pub(crate) doubts: Option<[u16; FEATURES]>,
}

pub(crate) fn holds(entry: &Entry) -> bool {
    u64::from_le_bytes(*entry) != 0
}

const fn signed(value: u8) -> i16 {
    value.cast_signed() as i16
}

impl Around {
    /// Of entry `before.len()` of a plane with rows of so many.
    #[inline(always)]
    pub(crate) fn of(before: &[Entry], row: usize) -> Self {
        let (i, x) = (before.len(), before.len() % row);
        let at = |is_inside: bool, back: usize| {
            let entry = before.get(i.wrapping_sub(back)).filter(|_| is_inside)?;
            holds(entry).then_some(*entry)
        };
        Self([at(x > 0, 1), at(true, row), at(x > 0, row + 1), at(x + 1 < row, row - 1)])
    }

    /// Which of them there are.
    #[inline(always)]
    pub(crate) fn context(&self) -> usize {
        (0..4).map(|i| usize::from(self.0[i].is_some()) << i).sum()
    }

    #[inline(always)]
    pub(crate) fn expected(&self) -> Expected {
        let [beside, above, corner, behind] = self.0;
        let mut expected = Expected { values: [0; FEATURES], doubts: None };
        if let (Some(beside), Some(above), Some(corner)) = (beside, above, corner) {
            let behind = behind.unwrap_or(above);
            let mut doubts = [0; FEATURES];
            for (v, doubt) in doubts.iter_mut().enumerate() {
                let (a, b) = (signed(beside[v]), signed(above[v]));
                let (c, d) = (signed(corner[v]), signed(behind[v]));
                let sum = (9 * a + 7 * b - 3 * c + 3 * d + 8) >> 4;
                expected.values[v] = sum.clamp(i8::MIN.into(), i8::MAX.into()) as i8;
                *doubt = a.abs_diff(c) + b.abs_diff(c) + d.abs_diff(b);
            }
            expected.doubts = Some(doubts);
        } else if let (Some(a), Some(b)) = (beside, above) {
            for v in 0..FEATURES {
                expected.values[v] = ((signed(a[v]) + signed(b[v])) >> 1) as i8;
            }
        } else if let Some(one) = beside.or(above).or(behind).or(corner) {
            expected.values = one.map(u8::cast_signed);
        }
        expected
    }
}

impl Expected {
    /// The class of a value, where doubts up to each of the limits make another one.
    #[inline(always)]
    pub(crate) fn class(&self, v: usize, limits: [u8; CLASSES - 2]) -> usize {
        match &self.doubts {
            Some(doubts) => limits.iter().filter(|limit| doubts[v] > u16::from(**limit)).count(),
            None => CLASSES - 1,
        }
    }
}

/// The entries of a plane.
pub(crate) fn unpack(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let ([a, b, step], packed) = packed.split_first_chunk()?;
    let (limits, packed) = packed.split_first_chunk::<{ CLASSES - 2 }>()?;
    let (zeros, mut packed) = packed.split_first_chunk::<{ 2 * CONTEXTS }>()?;
    let row = usize::from(u16::from_le_bytes([*a, *b]));
    let zeros = zeros.as_chunks::<2>().0;
    let mut frequencies = [Frequencies::NONE; CLASSES];
    for frequencies in &mut frequencies {
        frequencies.read(&mut packed)?;
    }
    let is_sound = |zeros: &[u8; 2]| u32::from(u16::from_le_bytes(*zeros)) <= TOTAL;
    let entries = out.as_chunks_mut::<FEATURES>();
    if row == 0 || !zeros.iter().all(is_sound) || !entries.1.is_empty() {
        return None;
    }
    let entries = entries.0;
    let mut symbols = SymbolReader::new(packed)?;
    for i in 0..entries.len() {
        let (before, own) = entries.split_at_mut(i);
        let around = Around::of(before, row);
        let zeros = u16::from_le_bytes(zeros[around.context()]);
        if !symbols.bit(0, zeros.into()) {
            own[0].fill(0);
            continue;
        }
        let expected = around.expected();
        for (v, value) in own[0].iter_mut().enumerate() {
            let code = symbols.byte(v % 2, &frequencies[expected.class(v, *limits)]);
            let expected = expected.values[v].cast_unsigned();
            *value = expected.wrapping_add(code).wrapping_sub(AS_EXPECTED);
        }
    }
    if !symbols.is_at_end() {
        return None;
    }
    if *step != 1 {
        // No branch a value: so the compiler takes many at once.
        let mut is_too_large = false;
        for value in out {
            let product = signed(*value) * i16::from(*step);
            *value = product as u8;
            is_too_large |= product != signed(*value);
        }
        return (!is_too_large).then_some(());
    }
    Some(())
}
