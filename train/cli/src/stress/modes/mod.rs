//! The known ways to fail, by what is spoilt.

mod alpha;
pub mod cameras;
mod files;
mod photos;
mod rendering;
mod scenes;
mod settings;

use super::Mode;

/// All of them, in the order of the table.
#[must_use]
pub fn all() -> Vec<Mode> {
    let groups = [
        settings::MODES,
        cameras::MODES,
        photos::MODES,
        alpha::MODES,
        files::MODES,
        rendering::MODES,
        scenes::MODES,
    ];
    groups.concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stress::Context;

    #[test]
    fn names_differ_and_strengths_have_an_order() {
        let modes = all();
        let mut names: Vec<&str> = modes.iter().map(|mode| mode.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), modes.len());
        for mode in &modes {
            assert!(mode.strengths.contains(&mode.quick), "{}", mode.name);
            assert!(mode.strengths.iter().all(|strength| strength.is_finite()), "{}", mode.name);
        }
    }

    #[test]
    fn models_of_different_cases_have_different_names() {
        let context = Context {
            aabb: Some([[-1.0; 3], [1.0; 3]]),
            distance: 4.0,
            steps: 600,
            downscale_factor: 4,
            entries: Some(|log2| ["--entries".to_owned(), log2.to_string()]),
            has_alpha: true,
            forward_facing: false,
            still_life: true,
        };
        let mut ids = Vec::new();
        for mode in all() {
            for strength in mode.strengths {
                let Some(case) = (mode.case)(*strength, &context) else { continue };
                let id = format!("{} {}", case.training.id(), case.viewing.id());
                let reference = format!("{} {}", case.reference.0.id(), case.reference.1.id());
                assert!(id != reference || mode.bar.figure() != "loss, dB", "{} {id}", mode.name);
                ids.push(id);
            }
        }
        let all = ids.len();
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), all, "each case measures something else");
    }
}
