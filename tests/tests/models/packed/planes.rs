//! `SPEC.md` is enough to unpack a plane.

use pocketnerf_core::encoding::planes::{FEATURES, Pair, Planes};
use pocketnerf_core::{AnyField, DType, Layout, Model, TensorView};
use pocketnerf_formats::{Precision, write};
use pocketnerf_tests::tiny::{self, Tiny};

use super::symbols::Symbols;

/// Entries along an axis.
const SIDE: usize = 18;

/// A file with planes as training makes them: smooth, with holes; some of them rounded.
pub(super) fn smooth() -> Vec<u8> {
    let value = |plane: usize, i: usize| {
        let [x, y] = [i / FEATURES % SIDE, i / FEATURES / SIDE].map(|c| c as f32);
        let v = (i % FEATURES) as f32;
        let noise = (i * i % 7) as f32;
        let wave = 90.0 * ((0.2 + 0.02 * v) * x + 0.15 * y + plane as f32).sin() + noise;
        let is_hole = (x - 9.0).hypot(y - 4.0 * plane as f32) < 5.0;
        // In units of 1 / 128, of which a step has 1, 4, ...
        let step = (1 << (2 * (plane % 3))) as f32;
        if is_hole { 0.0 } else { (wave / step).round() * step / 128.0 }
    };
    let bytes = |plane: usize, n: usize| -> Vec<u8> {
        (0..n).flat_map(|i| value(plane, i).to_le_bytes()).collect()
    };
    let tables = (0..6).map(|p| [bytes(p, SIDE * SIDE * FEATURES), bytes(p, SIDE * FEATURES)]);
    let tables: Vec<_> = tables.collect();
    let tiny = Tiny::trained();
    let model = tiny.planes();
    let AnyField::Planes(mut field) = model.field else { unreachable!() };
    for (pair, [plane, line]) in field.planes.pairs.iter_mut().zip(&tables) {
        *pair = Pair { plane: tensor(plane), line: tensor(line) };
    }
    field.planes = Planes { resolution: SIDE as u32, ..field.planes };
    // Nothing is known of what no cell reaches: without cells all entries stay.
    let model = Model { field: AnyField::Planes(field), occupancy: None, ..model };
    write(&model, &tiny::about(), Precision::I8).unwrap()
}

fn tensor(bytes: &[u8]) -> TensorView<'_> {
    let shape = [(bytes.len() / 4 / FEATURES) as u32, FEATURES as u32];
    TensorView::new(bytes, DType::F32, shape, 0, Layout::RowMajor).unwrap()
}

/// Encoding 6, as SPEC.md has it.
pub(super) fn by_hand(payload: &[u8], n: usize) -> Vec<u8> {
    let mut symbols = Symbols::new(payload, 0);
    let row = symbols.number(2) as usize;
    let step = symbols.number(1) as i32;
    let limits = [0; 2].map(|_| symbols.number(1) as i32);
    let zeros = [0; 16].map(|_| symbols.number(2));
    let tables = [0; 4].map(|_| symbols.frequencies());
    symbols.begin();
    let mut entries: Vec<[i32; 8]> = Vec::new();
    for i in 0..n / 8 {
        let [x, y] = [i % row, i / row].map(|c| c as i32);
        let entry = |dx: i32, dy: i32| {
            let (x, y) = (x + dx, y + dy);
            let inside = x >= 0 && x < row as i32 && y >= 0;
            let entry = inside.then(|| entries[(x + row as i32 * y) as usize]);
            entry.filter(|entry| *entry != [0; 8])
        };
        let around = [entry(-1, 0), entry(0, -1), entry(-1, -1), entry(1, -1)];
        let [a, b, c, d] = around;
        let context: usize =
            around.iter().enumerate().map(|(bit, e)| usize::from(e.is_some()) << bit).sum();
        let mut own = [0; 8];
        if symbols.next(0, &[zeros[context], 4096 - zeros[context]]) == 1 {
            for v in 0..8 {
                let (expected, table) = match (a, b, c) {
                    (Some(a), Some(b), Some(c)) => {
                        let d = d.unwrap_or(b);
                        let [a, b, c, d] = [a[v], b[v], c[v], d[v]];
                        let doubt = (a - c).abs() + (b - c).abs() + (d - b).abs();
                        let exceeded = limits.iter().filter(|limit| doubt > **limit).count();
                        let sum = 9 * a + 7 * b - 3 * c + 3 * d + 8;
                        (sum.div_euclid(16).clamp(-128, 127), exceeded)
                    }
                    (Some(a), Some(b), None) => ((a[v] + b[v]).div_euclid(2), 3),
                    _ => (a.or(b).or(d).or(c).map_or(0, |one| one[v]), 3),
                };
                let byte = symbols.next(v % 2, &tables[table]) as i32;
                own[v] = (expected + byte - 128 + 128).rem_euclid(256) - 128;
            }
        }
        entries.push(own);
    }
    assert_eq!((symbols.states, symbols.at), ([1 << 16; 2], payload.len()));
    let values = entries.iter().flatten();
    values.map(|value| i8::try_from(value * step).unwrap().cast_unsigned()).collect()
}
