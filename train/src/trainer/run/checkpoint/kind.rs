//! The kinds of section that only checkpoints have.

use pocketnerf_formats::kind::PROGRAM;

/// Everything small: settings, plan, counters.
pub const TRAINER: u32 = PROGRAM;
/// The first moments of the networks, f32, in the order of the model's tensors.
/// Grids have none.
pub const MEAN: u32 = PROGRAM + 1;
/// The second moments of all tensors.
pub const SQUARE: u32 = PROGRAM + 2;
/// Densities of the cells that may be occupied, f32.
pub const DENSITY: u32 = PROGRAM + 3;
/// Sum of the parameters of the steps that are averaged, f32, in the order of
/// the model's tensors; only once there are such steps.
pub const SUM: u32 = PROGRAM + 4;
/// How the forward pass rounds each level of the grid: the exponents of its
/// units, a byte each. Programs that had none rounded otherwise: without it, as
/// finely as holds the parameters.
pub const SCALES: u32 = PROGRAM + 5;
/// Squared error of each tile of the images, f32, and how often each is drawn, f32.
/// Programs that had none drew all alike, and without it so does this one until it
/// has looked again.
pub const PIXEL_ERRORS: u32 = PROGRAM + 6;
/// What else a run needs of its kind of field: vanilla NeRFs and voxels.
pub const KIND: u32 = PROGRAM + 7;
/// What was seen of the held-out views. Programs that held none out wrote none, and a run
/// of theirs goes on without.
pub const WATCH: u32 = PROGRAM + 8;
/// The parameters with which the held-out views were rendered best, f32, in the order of
/// the model's tensors, while there are such.
pub const BEST: u32 = PROGRAM + 9;
/// The vector instructions of the steps so far, by their name on the command line. Without
/// it they are not known.
pub const SIMD: u32 = PROGRAM + 10;
/// By what each channel of each photograph is multiplied, f32; only where they are evened
/// out.
pub const EXPOSURE: u32 = PROGRAM + 11;
/// How the camera of each photograph turns, a rotation vector, and moves, f32; only where
/// poses are refined.
pub const POSES: u32 = PROGRAM + 12;
/// The first moments of these.
pub const POSE_MEAN: u32 = PROGRAM + 13;
/// The second moments.
pub const POSE_SQUARE: u32 = PROGRAM + 14;
/// Their sum over the steps that are averaged; only once there are such steps.
pub const POSE_SUM: u32 = PROGRAM + 15;
/// The logarithm of the factor by which the scene is brighter in each channel of each
/// photograph than EXPOSURE says, f32; only where that is learnt.
pub const GAINS: u32 = PROGRAM + 16;
/// The first moments of these.
pub const GAIN_MEAN: u32 = PROGRAM + 17;
/// The second moments.
pub const GAIN_SQUARE: u32 = PROGRAM + 18;
/// Their sum over the steps that are averaged; only once there are such steps.
pub const GAIN_SUM: u32 = PROGRAM + 19;
/// How much surfaces are held to be smooth, f32; only where they are.
pub const SMOOTH_SURFACES: u32 = PROGRAM + 20;
/// The model file of a teacher; only where the mean of what some show is learnt.
pub const TEACHER: u32 = PROGRAM + 21;
/// From how many times the usual density on a cell is occupied, after which share of the run that
/// began, and the best PSNR of the training views since, f32; only where fog is cleared.
pub const CLEARING: u32 = PROGRAM + 22;

/// The name of a kind of section, a model's or a checkpoint's.
#[must_use]
pub const fn section_name(kind: u32) -> Option<&'static str> {
    match kind {
        TRAINER => Some("TRAINER"),
        MEAN => Some("MEAN"),
        SQUARE => Some("SQUARE"),
        DENSITY => Some("DENSITY"),
        SUM => Some("SUM"),
        SCALES => Some("SCALES"),
        PIXEL_ERRORS => Some("PIXEL_ERRORS"),
        KIND => Some("KIND"),
        WATCH => Some("WATCH"),
        BEST => Some("BEST"),
        SIMD => Some("SIMD"),
        EXPOSURE => Some("EXPOSURE"),
        POSES => Some("POSES"),
        POSE_MEAN => Some("POSE_MEAN"),
        POSE_SQUARE => Some("POSE_SQUARE"),
        POSE_SUM => Some("POSE_SUM"),
        GAINS => Some("GAINS"),
        GAIN_MEAN => Some("GAIN_MEAN"),
        GAIN_SQUARE => Some("GAIN_SQUARE"),
        GAIN_SUM => Some("GAIN_SUM"),
        SMOOTH_SURFACES => Some("SMOOTH_SURFACES"),
        TEACHER => Some("TEACHER"),
        CLEARING => Some("CLEARING"),
        _ => pocketnerf_formats::kind::name(kind),
    }
}
