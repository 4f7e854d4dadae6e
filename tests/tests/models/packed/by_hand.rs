//! `SPEC.md` is enough to unpack a file.

use std::collections::BTreeSet;

use pocketnerf_formats::{
    Container, ContainerWriter, Precision, Section, SectionId, kind, pack, unpacked, write,
};
use pocketnerf_tests::tiny::{self, Tiny};

use super::{planes, still_life, symbols::Symbols};
use crate::golden::golden;
use crate::rounded;

/// Every encoding is in the golden files, which SPEC.md suffices to read.
#[test]
fn by_hand_from_the_specification() {
    let plain = write(&Tiny::trained().hash_grid(), &tiny::about(), Precision::I8).unwrap();
    let packed = golden("hash-grid-i8-packed.pnerf", &pack(&plain).unwrap());
    assert_eq!(unpacked_by_hand(&packed), [0, 1, 2, 3]);
    // Networks of so few values gain by steps that leave few of them.
    let plain = rounded::networks(&plain, 4096.0);
    let packed = golden("hash-grid-rounded-packed.pnerf", &pack(&plain).unwrap());
    assert_eq!(unpacked_by_hand(&packed), [0, 1, 2, 3, 4]);
    let plain = write(&Tiny::trained().plenoxels(), &tiny::about(), Precision::I8).unwrap();
    let packed = golden("plenoxels-i8-packed.pnerf", &pack(&smooth(&plain)).unwrap());
    assert!(unpacked_by_hand(&packed).contains(&5));
    let packed = golden("planes-i8-packed.pnerf", &pack(&planes::smooth()).unwrap());
    assert_eq!(unpacked_by_hand(&packed), [0, 4, 6]);
}

/// Voxels as training makes them: each is like those beside it, and so are the colours.
fn smooth(plain: &[u8]) -> Vec<u8> {
    let mut writer = ContainerWriter::new();
    for section in Container::open(plain).unwrap().sections() {
        let mut payload = section.bytes.to_vec();
        if section.id == SectionId::first(kind::GRID) {
            for (i, values) in payload.chunks_mut(16).enumerate() {
                let [x, y, z] = [i % 4, i / 4 % 4, i / 16 % 4].map(|c| c as f32);
                let brick = (i / 64) as f32;
                values[13..].fill(0);
                for (v, value) in values[..13].iter_mut().enumerate() {
                    let wave = (0.2 * x + 0.1 * y - 0.3 * z + brick + 0.1 * v as f32).sin();
                    *value = ((60.0 * wave) as i8 + (*value % 8) as i8).cast_unsigned();
                }
            }
        }
        writer.add(section.id, section.version, section.is_critical(), payload);
    }
    writer.finish().unwrap()
}

#[test]
fn chunks_of_zeros_take_two_bytes() {
    let file = still_life();
    let (mut writer, mut chunks) = (ContainerWriter::new(), Vec::new());
    for section in Container::open(&file).unwrap().sections() {
        let mut payload = section.bytes.to_vec();
        if section.id.kind == kind::GRID && payload.len() > 3 * 8192 {
            let zeros = if chunks.is_empty() { 0..payload.len() } else { 8192..3 * 8192 };
            payload[zeros].fill(0);
            chunks.push(payload.len().div_ceil(8192));
        }
        writer.add(section.id, section.version, section.is_critical(), payload);
    }
    assert!(chunks.len() > 1);
    let packed = pack(&writer.finish().unwrap()).unwrap();
    unpacked_by_hand(&packed);
    // A table of them has its block, the range of its bytes, and the frequency of one of them.
    let packed = Container::open(&packed).unwrap();
    let is_table = |section: &Section<'_>| section.id.kind == kind::GRID;
    let least = packed.sections().filter(is_table).map(|section| section.bytes.len()).min();
    assert_eq!(least, Some(1 + 2 + 2 + 2 * chunks[0]));
}

/// Compares the sections of a packed file with what SPEC.md makes of them; gives the encodings.
fn unpacked_by_hand(packed: &[u8]) -> Vec<u16> {
    let ordinary = unpacked(packed).unwrap();
    let [packed, ordinary] = [packed, &*ordinary].map(|bytes| Container::open(bytes).unwrap());
    let mut encodings = BTreeSet::new();
    for (section, expected) in packed.sections().zip(ordinary.sections()) {
        encodings.insert(section.encoding);
        let n = section.decoded_length as usize;
        let found = match section.encoding {
            0 => section.bytes.to_vec(),
            1 => table_by_hand(section.bytes, n),
            2 => blocks_by_hand(section.bytes, n),
            3 => cells_by_hand(section.bytes, n),
            4 => halves_by_hand(section.bytes, n),
            5 => voxels_by_hand(section.bytes, n),
            6 => planes::by_hand(section.bytes, n),
            other => panic!("{other}"),
        };
        assert!(found == expected.bytes, "{}", section.id);
    }
    encodings.into_iter().collect()
}

/// Encoding 4.
fn halves_by_hand(payload: &[u8], n: usize) -> Vec<u8> {
    let number = |at: usize| i16::from_le_bytes([payload[at], payload[at + 1]]);
    let codes = 3 + 2 * number(1) as usize;
    let mut large = (3..codes).step_by(2).map(number);
    let mut out = Vec::new();
    for code in table_by_hand(&payload[codes..], n / 2) {
        let multiple = match code {
            0 => large.next().unwrap(),
            code => i16::from(code) - 128,
        };
        let value = f32::from(multiple) * f32::from(payload[0]).exp2();
        out.extend(half::f16::from_f32(value).to_le_bytes());
    }
    assert_eq!(large.next(), None);
    out
}

/// Encoding 1, as SPEC.md has it.
fn table_by_hand(payload: &[u8], n: usize) -> Vec<u8> {
    let block = payload[0] as usize;
    let mut symbols = Symbols::new(payload, 1);
    let frequencies = symbols.frequencies();
    let chunks = n.div_ceil(8192);
    let lengths: Vec<usize> = (0..chunks).map(|_| symbols.number(2) as usize).collect();
    let mut out = Vec::new();
    for (i, length) in lengths.into_iter().enumerate() {
        let (at, size) = (symbols.at, (n - 8192 * i).min(8192));
        if length == 0 {
            out.extend(vec![0; size]);
            continue;
        }
        let blocks = size.div_ceil(block);
        let flags = if payload[at] == 0 { 0 } else { blocks.div_ceil(8) };
        let is_empty = |b: usize| flags > 0 && payload[at + 1 + b / 8] >> (b % 8) & 1 == 1;
        symbols.at = at + 1 + flags;
        symbols.begin();
        for b in 0..blocks {
            for place in 0..block.min(size - b * block) {
                out.push(match is_empty(b) {
                    true => 0,
                    false => symbols.next(place % 2, &frequencies) as u8,
                });
            }
        }
        assert_eq!((symbols.states, symbols.at), ([1 << 16; 2], at + length));
    }
    assert_eq!(symbols.at, payload.len());
    out
}

/// Bits of encodings 2 and 3; the contexts are numbered.
struct Bits<'b> {
    bytes: &'b [u8],
    range: u32,
    code: u32,
    contexts: Vec<u32>,
}

impl<'b> Bits<'b> {
    fn new(bytes: &'b [u8]) -> Self {
        let code = u32::from_be_bytes(bytes[..4].try_into().unwrap());
        Self { bytes: &bytes[4..], range: u32::MAX, code, contexts: vec![1024; 4096] }
    }

    fn next(&mut self, context: usize) -> bool {
        let p = &mut self.contexts[context];
        let bound = (self.range >> 11) * *p;
        let bit = self.code >= bound;
        if bit {
            (self.code, self.range) = (self.code - bound, self.range - bound);
            *p -= *p >> 5;
        } else {
            self.range = bound;
            *p += (2048 - *p) >> 5;
        }
        if self.range < 1 << 24 {
            self.range <<= 8;
            self.code = self.code << 8 | u32::from(self.bytes[0]);
            self.bytes = &self.bytes[1..];
        }
        bit
    }
}

/// A context: a bit for each of the places before (x, y, z).
fn context([x, y, z]: [i32; 3], before: &[[i32; 3]], is_set: impl Fn([i32; 3]) -> bool) -> usize {
    let at = before.iter().map(|[dx, dy, dz]| is_set([x + dx, y + dy, z + dz]));
    at.enumerate().map(|(bit, set)| usize::from(set) << bit).sum()
}

/// Encoding 2.
fn blocks_by_hand(payload: &[u8], n: usize) -> Vec<u8> {
    let side = i32::from(u16::from_le_bytes([payload[0], payload[1]]));
    let mut bits = Bits::new(&payload[2..]);
    let mut numbers: Vec<u16> = Vec::new();
    let mut last = 0;
    for i in 0..side * side * side {
        let at = [i % side, i / side % side, i / side / side];
        let before = [[-1, 0, 0], [0, -1, 0], [0, 0, -1], [-1, -1, 0], [-1, 0, -1], [0, -1, -1]];
        let holds = |[x, y, z]: [i32; 3]| {
            let inside = x >= 0 && y >= 0 && z >= 0;
            inside && numbers[(x + side * (y + side * z)) as usize] > 0
        };
        let bit = bits.next(context(at, &before, holds));
        last += u16::from(bit);
        numbers.push(if bit { last } else { 0 });
    }
    assert!(bits.bytes.len() <= 4 && numbers.len() * 2 == n);
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// Encoding 3.
fn cells_by_hand(payload: &[u8], n: usize) -> Vec<u8> {
    let mut bits = Bits::new(payload);
    let mut out = Vec::new();
    for _ in 0..n / 64 {
        let mut cells = [false; 512];
        for i in 0..512 {
            let at = [i % 8, i / 8 % 8, i / 64];
            let before = [
                [-1, -1, 0],
                [0, -1, 0],
                [1, -1, 0],
                [-1, 0, -1],
                [0, 0, -1],
                [1, 0, -1],
                [0, -1, -1],
                [0, 1, -1],
                [-1, 0, 0],
            ];
            let is_set = |place: [i32; 3]| {
                let inside = place.iter().all(|c| (0..8).contains(c));
                inside && cells[(place[0] + 8 * (place[1] + 8 * place[2])) as usize]
            };
            cells[i as usize] = bits.next(context(at, &before, is_set));
        }
        let byte = |row: &[bool]| (0..8).map(|x| u8::from(row[x]) << x).sum::<u8>();
        out.extend(cells.chunks(8).map(byte));
    }
    assert!(bits.bytes.len() <= 4);
    out
}

/// Encoding 5.
fn voxels_by_hand(payload: &[u8], n: usize) -> Vec<u8> {
    let (width, h) = (payload[0] as usize, payload[1] as usize);
    let mut bits = Bits::new(&payload[2..]);
    let mut out = Vec::new();
    let mut held = false;
    for _ in 0..n / (64 * width) {
        held = bits.next(usize::from(held));
        let mut brick: Vec<Option<Vec<i32>>> = Vec::new();
        for corner in 0..64i32 {
            let at = [corner % 4, corner / 4 % 4, corner / 16];
            let steps = [1, 4, 16].map(|step| corner - step);
            let beside: Vec<Option<Vec<i32>>> = (0..3)
                .map(|axis| (at[axis] > 0).then(|| brick[steps[axis] as usize].clone()).flatten())
                .collect();
            let context =
                (0..3).map(|axis| usize::from(beside[axis].is_some()) << axis).sum::<usize>();
            let holds = held && bits.next(2 + context);
            let beside: Vec<Vec<i32>> = beside.into_iter().flatten().collect();
            brick.push(holds.then(|| corner_by_hand(&mut bits, h, &beside)));
        }
        for corner in brick {
            let mut values = corner.unwrap_or_default();
            values.resize(width, 0);
            out.extend(values.iter().map(|value| i8::try_from(*value).unwrap().cast_unsigned()));
        }
    }
    assert!(bits.bytes.len() <= 4 && out.len() == n);
    out
}

/// The values of a corner that holds something.
fn corner_by_hand(bits: &mut Bits<'_>, h: usize, beside: &[Vec<i32>]) -> Vec<i32> {
    let mut values: Vec<i32> = Vec::new();
    let mut means: Vec<i32> = Vec::new();
    for i in 0..1 + 3 * h {
        let told = || beside.iter().map(|corner| corner[i]);
        let mean = if beside.is_empty() { 0 } else { told().sum::<i32>() / beside.len() as i32 };
        let s = if i > h { values[i - h] - means[i - h] } else { 0 };
        let class = match beside.len() {
            0 => 7,
            1 => (format!("{:b}", s.abs() + 4).len()).min(6),
            _ => match s.abs() + (told().max().unwrap() - told().min().unwrap()) / 2 {
                0 => 0,
                doubt => format!("{doubt:b}").len().min(6),
            },
        };
        // 8 of zero, 3 of signs, 64 of lengths, 8 of first digits, a new one.
        let own = 16 + 100 * i;
        let expected = (mean + s).clamp(-128, 127);
        let mut value = expected;
        if !bits.next(own + class) {
            let is_negative = bits.next(own + 8 + (s.signum() + 1) as usize);
            let mut length = 0;
            while length < 7 && bits.next(own + 11 + 8 * class + length) {
                length += 1;
            }
            let mut magnitude = 1;
            for digit in 0..length {
                let context = own + if digit == 0 { 75 + length } else { 99 };
                bits.contexts[own + 99] = 1024;
                magnitude = 2 * magnitude + i32::from(bits.next(context));
            }
            value += if is_negative { -magnitude } else { magnitude };
        }
        values.push(value);
        means.push(mean);
    }
    values
}
