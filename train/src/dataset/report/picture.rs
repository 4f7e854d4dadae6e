//! A picture of a dataset's cameras and of the scene's box, as SVG.

use std::fmt::Write as _;
use std::path::Path;

use glam::{DVec2, DVec3};
use pocketnerf_core::Camera;

use super::look::scene_box;
use super::shot::{Shot, distinct};
use super::{DatasetError, LoadOptions, Split, listings};
use crate::cameras::nearest_to_axes;
use crate::dataset::listing::Listing;

/// Width and height of a panel, pixels.
const SIDE: f64 = 480.0;
/// Room around what a panel shows.
const MARGIN: f64 = 40.0;
/// Length of a frustum as a share of what is shown.
const FRUSTUM: f64 = 0.06;
/// Colours of training and other cameras, and of the box (Okabe and Ito 2008).
const COLORS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];

/// Two axes of the world, to the right and upwards, each with its name and sign.
struct Panel {
    title: &'static str,
    axes: [(&'static str, DVec3); 2],
}

/// What is drawn.
struct Drawing<'d, 'l> {
    shots: &'d [&'d Shot<'l>],
    corners: Vec<DVec3>,
    at: Option<DVec3>,
    /// Scene units along a side of a panel.
    extent: f64,
    middle: DVec3,
}

/// The cameras (as frusta, each with its image's name) and the scene's box of the dataset in the
/// folder `path`, from above and from the side: SVG that needs nothing else.
///
/// # Errors
/// As [`inspect`](super::inspect).
pub fn picture(path: &Path, options: &LoadOptions) -> Result<String, DatasetError> {
    let listings = listings(path, options)?;
    let first = &listings[0].1;
    let splits: Vec<Vec<Shot<'_>>> =
        listings.iter().map(|(split, listing)| Shot::all(*split, listing)).collect();
    let shots = distinct(&splits);
    let drawing = Drawing::new(&shots, first);
    let mut svg = String::new();
    let (width, height) = (2.0 * SIDE, SIDE + MARGIN);
    _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"13\" fill=\"none\" stroke-width=\"1\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>"
    );
    for (i, panel) in panels(first.forward_facing).iter().enumerate() {
        _ = writeln!(svg, "<g transform=\"translate({} 0)\">", SIDE * i as f64);
        drawing.draw(panel, &mut svg);
        svg.push_str("</g>\n");
    }
    let legend = [
        (COLORS[0], "to learn from"),
        (COLORS[1], "held out or for tests"),
        (COLORS[2], "the scene's box"),
    ];
    for (i, (color, text)) in legend.into_iter().enumerate() {
        let x = MARGIN + 180.0 * i as f64;
        let y = SIDE + 0.5 * MARGIN;
        _ = writeln!(svg, "<text x=\"{x}\" y=\"{y}\" fill=\"{color}\">{text}</text>");
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// The world's z points up; that of a forward-facing capture towards the cameras, and y up.
fn panels(forward_facing: bool) -> [Panel; 2] {
    let (x, y, z) = (("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z));
    let ahead = ("-z", DVec3::NEG_Z);
    let axes = if forward_facing { [[x, ahead], [ahead, y]] } else { [[x, y], [x, z]] };
    let [above, side] = axes;
    [Panel { title: "from above", axes: above }, Panel { title: "from the side", axes: side }]
}

impl<'d, 'l> Drawing<'d, 'l> {
    fn new(shots: &'d [&'d Shot<'l>], listing: &Listing) -> Self {
        let poses: Vec<[f32; 16]> = shots.iter().map(|shot| shot.frame.pose).collect();
        let corner = |[min, max]: [[f32; 3]; 2], i: usize| {
            DVec3::from_array([0, 1, 2].map(|a| [min, max][i >> a & 1][a].into()))
        };
        let corners: Vec<DVec3> = scene_box(listing)
            .map_or_else(Vec::new, |bounds| (0..8).map(|i| corner(bounds, i)).collect());
        let shown = || shots.iter().map(|shot| position(shot)).chain(corners.iter().copied());
        let (min, max) = (
            shown().fold(DVec3::INFINITY, DVec3::min),
            shown().fold(DVec3::NEG_INFINITY, DVec3::max),
        );
        let extent = (max - min).max_element().max(1e-12) * (1.0 + 2.0 * FRUSTUM);
        let at = nearest_to_axes(&poses).filter(|_| !listing.forward_facing);
        Self { shots, corners, at, extent, middle: 0.5 * (min + max) }
    }

    fn draw(&self, panel: &Panel, svg: &mut String) {
        let inner = SIDE - 2.0 * MARGIN;
        let scale = inner / self.extent;
        let place = |p: DVec3| {
            let [right, up] = panel.axes.map(|(_, axis)| axis.dot(p - self.middle) * scale);
            DVec2::new(0.5 * SIDE + right, 0.5 * SIDE - up)
        };
        let [right, up] = panel.axes.map(|(name, _)| name);
        _ = writeln!(
            svg,
            "<text x=\"{MARGIN}\" y=\"20\" fill=\"black\">{}, {right} to the right, {up} up</text>\n\
             <rect x=\"{m}\" y=\"{m}\" width=\"{s}\" height=\"{s}\" stroke=\"#ccc\"/>",
            panel.title,
            m = 0.75 * MARGIN,
            s = inner + 0.5 * MARGIN
        );
        for i in 0..self.corners.len() {
            for a in (0..3).filter(|a| i >> a & 1 == 0) {
                line(svg, place(self.corners[i]), place(self.corners[i | 1 << a]), COLORS[2]);
            }
        }
        if let Some(at) = self.at.map(place).filter(|at| at.is_finite()) {
            let (x, y) = (DVec2::new(4.0, 0.0), DVec2::new(0.0, 4.0));
            line(svg, at - x, at + x, "black");
            line(svg, at - y, at + y, "black");
        }
        for shot in self.shots {
            let color = COLORS[usize::from(shot.split != Split::Train)];
            _ = writeln!(svg, "<g><title>{}</title>", escape(shot.name()));
            let eye = place(position(shot));
            let corners = frustum(shot, FRUSTUM * self.extent).map(place);
            for (corner, next) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                line(svg, eye, *corner, color);
                line(svg, *corner, *next, color);
            }
            svg.push_str("</g>\n");
        }
        // A length to measure by.
        let unit = 10f64.powf((0.4 * self.extent).log10().floor());
        let (from, y) = (0.75 * MARGIN, SIDE - 0.25 * MARGIN);
        let to = DVec2::new(from + unit * scale, y);
        line(svg, DVec2::new(from, y), to, "black");
        let x = to.x + 6.0;
        _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y}\" fill=\"black\">{unit} units</text>");
    }
}

fn position(shot: &Shot<'_>) -> DVec3 {
    let pose = &shot.frame.pose;
    DVec3::new(pose[3].into(), pose[7].into(), pose[11].into())
}

/// The corners of a picture at a distance before its camera.
fn frustum(shot: &Shot<'_>, length: f64) -> [DVec3; 4] {
    // Where the image is missing, only the pose is known.
    let camera = shot.camera.unwrap_or(Camera::from_fov_x(4, 3, 0.7, shot.frame.pose));
    let (w, h) = (camera.width as f32, camera.height as f32);
    [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(|[x, y]| {
        let direction = camera.ray(x, y).direction;
        position(shot) + length * DVec3::from_array(direction.map(f64::from))
    })
}

fn line(svg: &mut String, from: DVec2, to: DVec2, color: &str) {
    _ = writeln!(
        svg,
        "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"{color}\"/>",
        from.x, from.y, to.x, to.y
    );
}

/// Text that is no markup.
fn escape(text: &str) -> String {
    crate::json::escape(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
