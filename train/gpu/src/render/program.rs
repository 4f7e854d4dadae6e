//! A model in a GPU's memory, the program that renders it, and what goes in and out.

use std::sync::mpsc;
use std::time::Duration;

use pocketnerf_core::{Model, Ray, RenderOptions};

use super::{Error, Gpu};
use crate::frame::Frame;
use crate::pack::Packed;
use crate::shader;

/// Bytes of a pixel: its colour, then its depth and samples.
const COLOR: u64 = 16;
const DISTANCE: u64 = 8;
/// Bytes of a ray.
const RAY: u64 = size_of::<Ray>() as u64;
/// A GPU that does not answer for so long is taken for lost.
const PATIENCE: Duration = Duration::from_secs(180);

#[derive(Debug)]
pub(super) struct Program {
    gpu: Gpu,
    pipeline: wgpu::ComputePipeline,
    frame: wgpu::Buffer,
    /// Weights, tables and cells.
    model: [wgpu::Buffer; 3],
}

/// Room for what goes in and out.
#[derive(Debug)]
pub(super) struct Band {
    pixels: u64,
    has_rays: bool,
    rays: wgpu::Buffer,
    colors: wgpu::Buffer,
    distances: wgpu::Buffer,
    /// Both, where the CPU can read them.
    read: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Band {
    /// Whether so many pixels fit.
    pub(super) const fn fits(&self, pixels: u64, has_rays: bool) -> bool {
        self.pixels >= pixels && (self.has_rays || !has_rays)
    }
}

impl Program {
    /// Takes `model` into the GPU's memory and compiles what renders it.
    pub(super) fn new(
        gpu: &Gpu,
        model: &Model<'_>,
        options: &RenderOptions,
    ) -> Result<Self, Error> {
        let packed = Packed::new(model)?;
        let pipeline = compile(gpu, shader::source(model, &packed, options))?;
        let frame = gpu.buffer(
            "frame",
            size_of_val(&Frame::default().words()) as u64,
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        )?;
        let weights = gpu.upload("networks", bytemuck::cast_slice(&packed.weights))?;
        let tables = gpu.upload("hash tables", bytemuck::cast_slice(&packed.tables))?;
        let cells = gpu.upload("cells", bytemuck::cast_slice(&packed.occupancy))?;
        Ok(Self { gpu: gpu.clone(), pipeline, frame, model: [weights, tables, cells] })
    }

    /// Pixels at a time at most, as buffers go.
    pub(super) fn most_pixels(&self) -> u32 {
        (self.gpu.most_bytes() / (COLOR + DISTANCE)).min(1 << 22) as u32
    }

    /// Room for so many pixels.
    pub(super) fn band(&self, pixels: u64, has_rays: bool) -> Result<Band, Error> {
        use wgpu::BufferUsages as Usage;
        let gpu = &self.gpu;
        let out = Usage::STORAGE | Usage::COPY_SRC;
        let n_rays = if has_rays { pixels } else { 1 };
        let rays = gpu.buffer("rays", RAY * n_rays, Usage::STORAGE | Usage::COPY_DST)?;
        let colors = gpu.buffer("pixels", COLOR * pixels, out)?;
        let distances = gpu.buffer("pixels", DISTANCE * pixels, out)?;
        let both = (COLOR + DISTANCE) * pixels;
        let read = gpu.buffer("pixels", both, Usage::MAP_READ | Usage::COPY_DST)?;
        let [weights, tables, cells] = &self.model;
        let buffers = [&self.frame, weights, tables, cells, &rays, &colors, &distances];
        let entries = buffers.iter().enumerate().map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding: binding as u32,
            resource: buffer.as_entire_binding(),
        });
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("render"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries.collect::<Vec<_>>(),
        });
        gpu.check()?;
        Ok(Band { pixels, has_rays, rays, colors, distances, read, group })
    }

    /// Renders the pixels of `frame`, whose `rays` are given or none, and hands over their
    /// colours and, of each, depth and samples.
    pub(super) fn run<T>(
        &self,
        band: &Band,
        frame: &Frame,
        rays: &[Ray],
        take: impl FnOnce(&[u8], &[[u8; 8]]) -> T,
    ) -> Result<T, Error> {
        let [width, rows] = frame.size();
        let n = u64::from(width) * u64::from(rows);
        let Gpu { device, queue, .. } = &self.gpu;
        if !rays.is_empty() {
            // A ray is its six numbers.
            let numbers: Vec<_> = rays.iter().map(|ray| [ray.origin, ray.direction]).collect();
            queue.write_buffer(&band.rays, 0, bytemuck::cast_slice(&numbers));
        }
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame.words()));
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &band.group, &[]);
        pass.dispatch_workgroups(width.div_ceil(8), rows.div_ceil(8), 1);
        drop(pass);
        let [colors, distances] = [COLOR, DISTANCE].map(|bytes| bytes * n);
        encoder.copy_buffer_to_buffer(&band.colors, 0, &band.read, 0, colors);
        encoder.copy_buffer_to_buffer(&band.distances, 0, &band.read, colors, distances);
        let asked = queue.submit([encoder.finish()]);
        self.read(asked, &band.read, colors + distances, |bytes| {
            let (colors, distances) = bytes.split_at(colors as usize);
            take(colors, distances.as_chunks().0)
        })
    }

    /// Waits for what was `asked` for, and hands over the first `bytes` of a buffer.
    fn read<T>(
        &self,
        asked: wgpu::SubmissionIndex,
        buffer: &wgpu::Buffer,
        bytes: u64,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, Error> {
        let failed = |error: &dyn std::fmt::Display| Error::Device(error.to_string());
        let (sender, receiver) = mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            // Nobody waits where polling has failed.
            let _ = sender.send(result);
        });
        let wait = wgpu::PollType::Wait { submission_index: Some(asked), timeout: Some(PATIENCE) };
        let polled = self.gpu.device.poll(wait);
        self.gpu.check()?;
        polled.map_err(|error| failed(&error))?;
        // Another thread that polls the same device may be the one that says it.
        let result = receiver.recv_timeout(PATIENCE).map_err(|error| failed(&error))?;
        result.map_err(|error| failed(&error))?;
        let mapped = buffer.get_mapped_range(..bytes).map_err(|error| failed(&error))?;
        let taken = take(&mapped);
        drop(mapped);
        buffer.unmap();
        Ok(taken)
    }
}

fn compile(gpu: &Gpu, source: String) -> Result<wgpu::ComputePipeline, Error> {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("render"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    gpu.check()?;
    let layout = gpu.device.create_bind_group_layout(&layout());
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("render"),
        bind_group_layouts: &[Some(&layout)],
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("render"),
        layout: Some(&layout),
        module: &module,
        entry_point: Some("render"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    gpu.check()?;
    Ok(pipeline)
}

/// What `ray.wgsl` declares.
fn layout() -> wgpu::BindGroupLayoutDescriptor<'static> {
    const fn entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
        wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        }
    }
    const IN: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };
    const OUT: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };
    const ENTRIES: [wgpu::BindGroupLayoutEntry; 7] = [
        entry(0, wgpu::BufferBindingType::Uniform),
        entry(1, IN),
        entry(2, IN),
        entry(3, IN),
        entry(4, IN),
        entry(5, OUT),
        entry(6, OUT),
    ];
    wgpu::BindGroupLayoutDescriptor { label: Some("render"), entries: &ENTRIES }
}
