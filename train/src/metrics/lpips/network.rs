//! The networks whose features are compared.

/// A network, up to its last tap.
#[derive(Debug)]
pub(super) struct Network {
    pub(super) name: &'static str,
    pub(super) steps: &'static [Step],
}

/// What is done with the features.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// A convolution and what is less than 0 made 0.
    Convolve(Shape),
    /// The largest of `side` × `side` values, every second pixel.
    Pool {
        /// In pixels.
        side: usize,
    },
    /// Here features are compared.
    Tap,
}

/// A convolution's shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// Of the kernel, pixels.
    pub(super) side: usize,
    /// From one output pixel to the next.
    pub(super) stride: usize,
    /// Zeros around the picture, pixels.
    pub(super) padding: usize,
    /// Channels that go in.
    pub(super) from: usize,
    /// Channels that come out.
    pub(super) to: usize,
}

impl Network {
    /// Those that are known.
    pub(super) const ALL: [&Self; 2] = [&ALEX_NET, &VGG_16];

    /// Its convolutions.
    pub(super) fn shapes(&self) -> impl Iterator<Item = Shape> {
        self.steps.iter().filter_map(|step| match step {
            Step::Convolve(shape) => Some(*shape),
            Step::Pool { .. } | Step::Tap => None,
        })
    }

    /// The channels of each tap.
    pub(super) fn taps(&self) -> impl Iterator<Item = usize> {
        let mut channels = 0;
        self.steps.iter().filter_map(move |step| {
            if let Step::Convolve(shape) = step {
                channels = shape.to;
            }
            matches!(step, Step::Tap).then_some(channels)
        })
    }
}

/// 3×3, and the picture keeps its size.
const fn three(from: usize, to: usize) -> Step {
    Step::Convolve(Shape { side: 3, stride: 1, padding: 1, from, to })
}

/// Krizhevsky: One weird trick for parallelizing convolutional neural networks, 2014, in
/// torchvision's form.
static ALEX_NET: Network = Network {
    name: "AlexNet",
    steps: &[
        Step::Convolve(Shape { side: 11, stride: 4, padding: 2, from: 3, to: 64 }),
        Step::Tap,
        Step::Pool { side: 3 },
        Step::Convolve(Shape { side: 5, stride: 1, padding: 2, from: 64, to: 192 }),
        Step::Tap,
        Step::Pool { side: 3 },
        three(192, 384),
        Step::Tap,
        three(384, 256),
        Step::Tap,
        three(256, 256),
        Step::Tap,
    ],
};

/// Simonyan, Zisserman: Very deep convolutional networks for large-scale image recognition,
/// 2015, table 1, column D.
static VGG_16: Network = Network {
    name: "VGG16",
    steps: &[
        three(3, 64),
        three(64, 64),
        Step::Tap,
        Step::Pool { side: 2 },
        three(64, 128),
        three(128, 128),
        Step::Tap,
        Step::Pool { side: 2 },
        three(128, 256),
        three(256, 256),
        three(256, 256),
        Step::Tap,
        Step::Pool { side: 2 },
        three(256, 512),
        three(512, 512),
        three(512, 512),
        Step::Tap,
        Step::Pool { side: 2 },
        three(512, 512),
        three(512, 512),
        three(512, 512),
        Step::Tap,
    ],
};
