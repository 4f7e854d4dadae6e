//! Where rays are within boxes.

/// The distances at which a line enters a box and leaves it: the second is smaller where it misses.
pub(super) fn within(
    origin: [f32; 3],
    direction: [f32; 3],
    [low, high]: [[f32; 3]; 2],
) -> [f32; 2] {
    let mut span = [f32::NEG_INFINITY, f32::INFINITY];
    for a in 0..3 {
        if direction[a] == 0.0 {
            if !(low[a]..=high[a]).contains(&origin[a]) {
                return [f32::INFINITY, f32::NEG_INFINITY];
            }
            continue;
        }
        let [t, u] = [low[a], high[a]].map(|side| (side - origin[a]) / direction[a]);
        span = [span[0].max(t.min(u)), span[1].min(t.max(u))];
    }
    span
}

/// The entry below a grid position and how far the position is beyond it, so that there is a next
/// entry.
pub(super) fn between(position: f32, entries: usize) -> (usize, f32) {
    let below = (position.max(0.0) as usize).min(entries - 2);
    (below, (position - below as f32).clamp(0.0, 1.0))
}

/// The point at a distance.
pub(super) fn at(origin: [f32; 3], direction: [f32; 3], t: f32) -> [f32; 3] {
    [0, 1, 2].map(|a| origin[a] + t * direction[a])
}
