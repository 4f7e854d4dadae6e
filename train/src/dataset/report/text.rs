//! The check report as text.

use std::fmt;

use super::{DatasetReport, SplitReport};
use crate::json::escape;

impl fmt::Display for DatasetReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "dataset   {}", escape(&self.source))?;
        writeln!(
            f,
            "format    {}, by {} (poses here: camera-to-world, x right, y up, looking along -z)",
            self.format,
            escape(&self.recognised_by)
        )?;
        if let Some([near, far]) = self.bounds {
            writeln!(f, "depths    from {near:.3} to {far:.3}, the dataset says")?;
        }
        match (self.forward_facing, self.scene_box) {
            (true, _) => writeln!(f, "scene     forward-facing: no box, all lies along -z")?,
            (false, Some([low, high])) => {
                if self.has_no_end {
                    writeln!(
                        f,
                        "space     contracted, without an end; a box if one plain background is \
                         behind all"
                    )?;
                }
                let by = match (self.scene_box_given, self.scene_box_by_points) {
                    (true, _) => "the dataset says",
                    (false, true) => "by its points",
                    (false, false) => "by the cameras",
                };
                writeln!(f, "scene     box from {} to {}, {by}", point(low), point(high))?;
            }
            (false, None) => {}
        }
        match self.hold_every {
            None => {}
            Some(0) => writeln!(f, "splits    none is held out (--hold-every 0)")?,
            Some(every) => {
                writeln!(f, "splits    one image in {every} is held out (--hold-every)")?;
            }
        }
        for note in &self.notes {
            writeln!(f, "note      {note}")?;
        }
        for suspicion in &self.suspicions {
            writeln!(f, "suspect   {}", suspicion.text)?;
        }
        for (i, split) in self.splits.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            let same = |other: &&SplitReport| {
                SplitReport { split: split.split, ..(*other).clone() } == *split
            };
            match self.splits[..i].iter().find(same) {
                Some(other) => write!(f, "{:<9} the images of {}", split.split, other.split)?,
                None => write!(f, "{split}")?,
            }
        }
        Ok(())
    }
}

impl fmt::Display for SplitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<9} {} frames, {} images found", self.split, self.frames, self.images_found)?;
        for (names, what) in [
            (&self.images_missing, "missing"),
            (&self.images_unreadable, "unreadable"),
            (&self.images_misshapen, "of another shape than their cameras"),
            (&self.masks_missing, "masks missing"),
        ] {
            if let Some(first) = names.first() {
                write!(f, ", {} {what} (first: {})", names.len(), escape(first))?;
            }
        }
        for size in &self.sizes {
            write!(f, "\n          {}x{} pixels: {} images", size.width, size.height, size.images)?;
        }
        let [low, high] = self.camera_box;
        write!(f, "\n          alpha channel in {} images", self.images_with_alpha)?;
        if self.masks > 0 {
            write!(f, ", masks for {}", self.masks)?;
        }
        write!(f, "\n          lens {}", self.lenses.join(", "))?;
        if let Some(degrees) = self.fov_x_degrees {
            write!(f, ", field of view {degrees:.2} degrees wide")?;
        }
        write!(f, "\n          cameras from {} to {}", point(low), point(high))?;
        if let (Some(at), Some([near, far])) = (self.look_at, self.look_at_distance) {
            let at = point(at);
            write!(f, "\n          looking at {at}, from {near:.3} to {far:.3} away")?;
        }
        if let Some(share) = self.share_looking_at_box {
            write!(f, "\n          {:.0} % of them look at the scene's box", 100.0 * share)?;
        }
        Ok(())
    }
}

fn point([x, y, z]: [f32; 3]) -> String {
    // Adding 0 after rounding to what is shown turns -0.000 into 0.000.
    let [x, y, z] = [x, y, z].map(|v| (v * 1e3).round() / 1e3 + 0.0);
    format!("({x:.3}, {y:.3}, {z:.3})")
}
