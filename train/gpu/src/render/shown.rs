//! Pictures that stay in a GPU's memory, and the bytes that a host wants of them.

use pocketnerf_core::{ColorSpace, Display};
use wgpu::BufferBindingType::{Storage, Uniform};
use wgpu::BufferUsages as Usage;

use super::band::Band;
use super::program::{Program, compile};
use super::{Error, Gpu};

/// Bytes of a pixel, and of what comes before all of them.
const PIXEL: u64 = 4;
const MOST: u64 = 4;
/// Pixels of a workgroup.
const GROUP: u32 = 256;

/// The program that makes bytes of colours.
#[derive(Debug)]
pub(super) struct Shown {
    pipelines: Vec<wgpu::ComputePipeline>,
    display: wgpu::Buffer,
    /// Samples that a pixel may have.
    max_samples: u32,
}

/// A picture in a GPU's memory.
#[derive(Debug)]
pub(super) struct Drawn {
    pub(super) band: Band,
    pub(super) pixels: u32,
    /// What the program says of all pixels, and their bytes.
    most: wgpu::Buffer,
    bytes: wgpu::Buffer,
    /// Both, where the CPU can read them.
    pub(super) read: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Drawn {
    /// What of `read` is filled.
    pub(super) fn read_bytes(&self) -> u64 {
        MOST + PIXEL * u64::from(self.pixels)
    }
}

impl Shown {
    pub(super) fn new(gpu: &Gpu, max_samples: u32) -> Result<Self, Error> {
        const READ: wgpu::BufferBindingType = Storage { read_only: true };
        const WRITE: wgpu::BufferBindingType = Storage { read_only: false };
        let source = wgsl!("shown").to_owned();
        let types = [Uniform, READ, READ, WRITE, WRITE];
        let pipelines = compile(gpu, source, &["show"], &types)?;
        let display = gpu.buffer("display", 32, Usage::UNIFORM | Usage::COPY_DST)?;
        Ok(Self { pipelines, display, max_samples })
    }

    /// Room for a picture of so many pixels.
    pub(super) fn drawn(&self, program: &Program, pixels: u64) -> Result<Drawn, Error> {
        let (gpu, most) = (program.gpu(), u64::from(program.most_pixels()));
        if pixels > most {
            let [bytes, most] = [pixels, most].map(|pixels| PIXEL * pixels);
            return Err(Error::TooLarge { what: "a picture", bytes, most });
        }
        let band = program.band(pixels, false)?;
        let all = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let most = gpu.buffer("most samples", MOST, all)?;
        let bytes = gpu.buffer("bytes", PIXEL * pixels, all)?;
        let usage = Usage::MAP_READ | Usage::COPY_DST;
        let read = gpu.buffer("bytes", MOST + PIXEL * pixels, usage)?;
        let buffers = [&self.display, &band.colors, &band.distances, &most, &bytes];
        let group = gpu.group(&self.pipelines[0], (0..).zip(buffers))?;
        Ok(Drawn { band, pixels: 0, most, bytes, read, group })
    }

    /// Asks for the bytes of a picture.
    pub(super) fn ask(&self, gpu: &Gpu, drawn: &Drawn, display: &Display) -> wgpu::SubmissionIndex {
        let [r, g, b] = display.background.map(f32::to_bits);
        let is_linear = display.color_space == ColorSpace::Linear;
        let flag = f32::from(u8::from(is_linear)).to_bits();
        let words = [r, g, b, flag, drawn.pixels, self.max_samples, 0, 0];
        gpu.queue.write_buffer(&self.display, 0, bytemuck::cast_slice(&words));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&drawn.most, 0, None);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipelines[0]);
        pass.set_bind_group(0, &drawn.group, &[]);
        pass.dispatch_workgroups(drawn.pixels.div_ceil(GROUP), 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&drawn.most, 0, &drawn.read, 0, MOST);
        let bytes = drawn.read_bytes() - MOST;
        encoder.copy_buffer_to_buffer(&drawn.bytes, 0, &drawn.read, MOST, bytes);
        gpu.queue.submit([encoder.finish()])
    }
}
