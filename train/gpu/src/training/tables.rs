//! The tables of a field that learns: how they follow their gradients, in and out.

use super::Learner;
use super::sequence::Sequence;
use super::step::Tables;
use crate::render::Error;

/// Values that are left alone only together: `tables.wgsl`.
const BLOCK: u32 = 16;

impl Learner {
    /// New tables from their gradients, and what is rounded of them.
    pub(super) fn follow(&self, to: &mut Sequence<'_>, average: bool) {
        let (f, p, gpu) = (&self.fixed, &self.pipelines, &self.gpu);
        let most = self.tables.iter().copied().max().unwrap_or(0);
        let n_levels = self.tables.len() as u32;
        let buffers = [
            (0, &f.frame),
            (9, &f.counters),
            (30, &f.table_of),
            (31, &f.units),
            (32, &f.entry_gradients),
            (33, &f.parameters),
            (34, &f.squares),
            (35, &f.largest),
        ];
        let group = p.adam.group(gpu, &buffers);
        p.adam.run(to, &group, [most.div_ceil(64 * BLOCK), n_levels, 1]);
        self.round(to);
        if let (true, Some(averaged)) = (average, &f.averaged) {
            let group = p.accumulate.group(gpu, &[(33, &f.parameters), (39, averaged)]);
            p.accumulate.run(to, &group, [2048, 1, 1]);
        }
    }

    /// What fields read of the tables.
    fn round(&self, to: &mut Sequence<'_>) {
        let (f, p, gpu) = (&self.fixed, &self.pipelines, &self.gpu);
        let most = self.tables.iter().copied().max().unwrap_or(0);
        let buffers = [(35, &f.largest), (36, &f.scales), (37, &f.factors)];
        let group = p.hold_all.group(gpu, &buffers);
        p.hold_all.run(to, &group, [1; 3]);
        let buffers = [(30, &f.table_of), (33, &f.parameters), (36, &f.scales), (38, &f.rounded)];
        let group = p.round_all.group(gpu, &buffers);
        p.round_all.run(to, &group, [most.div_ceil(64 * 4), self.tables.len() as u32, 1]);
    }

    /// Takes over tables that are set all at once.
    ///
    /// # Errors
    /// [`Error::Device`] or [`Error::TooLarge`].
    pub fn set_tables(&mut self, tables: &Tables) -> Result<(), Error> {
        let (f, queue) = (&self.fixed, self.gpu.queue());
        let scales: &[[i32; 2]] = &tables.scales;
        queue.write_buffer(&f.parameters, 0, bytemuck::cast_slice(&tables.parameters));
        queue.write_buffer(&f.squares, 0, bytemuck::cast_slice(&tables.square));
        queue.write_buffer(&f.scales, 0, bytemuck::cast_slice(scales));
        queue.write_buffer(&f.largest, 0, &vec![0; f.largest.size() as usize]);
        let mut all = Sequence::new(&self.gpu, None);
        all.encoder().clear_buffer(&f.entry_gradients, 0, None);
        self.round(&mut all);
        all.submit(&self.gpu);
        self.fixed.averaged = None;
        if !tables.sum.is_empty() {
            let averaged = self.table_buffer("sums of entries")?;
            self.gpu.queue().write_buffer(&averaged, 0, bytemuck::cast_slice(&tables.sum));
            self.fixed.averaged = Some(averaged);
        }
        self.gpu.check()
    }

    /// Rounds each table to multiples of so many units from now on.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn set_scales(&mut self, scales: &[[i32; 2]]) -> Result<(), Error> {
        self.gpu.queue().write_buffer(&self.fixed.scales, 0, bytemuck::cast_slice(scales));
        let mut all = Sequence::new(&self.gpu, None);
        self.round(&mut all);
        all.submit(&self.gpu);
        self.gpu.check()
    }

    /// The tables after the last step.
    ///
    /// # Errors
    /// [`Error::Device`] or [`Error::TooLarge`].
    pub fn tables(&self) -> Result<Tables, Error> {
        let f = &self.fixed;
        let scales = self.download::<i32>(&f.scales)?;
        Ok(Tables {
            parameters: self.download(&f.parameters)?,
            square: self.download(&f.squares)?,
            sum: f.averaged.as_ref().map_or(Ok(Vec::new()), |sums| self.download(sums))?,
            scales: scales.as_chunks().0.to_vec(),
        })
    }

    /// Room for a number an entry's value, all 0.
    pub(super) fn table_buffer(&self, what: &'static str) -> Result<wgpu::Buffer, Error> {
        use wgpu::BufferUsages as Usage;
        let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        self.gpu.buffer(what, self.fixed.parameters.size(), usage)
    }

    fn download<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, Error> {
        use wgpu::BufferUsages as Usage;
        let bytes = buffer.size();
        let read = self.gpu.buffer("tables", bytes, Usage::MAP_READ | Usage::COPY_DST)?;
        let mut all = Sequence::new(&self.gpu, None);
        all.encoder().copy_buffer_to_buffer(buffer, 0, &read, 0, bytes);
        let asked = all.submit(&self.gpu);
        self.gpu.read(asked, &read, bytes, |bytes| bytemuck::pod_collect_to_vec(bytes))
    }
}
