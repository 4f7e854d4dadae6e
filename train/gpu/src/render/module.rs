//! Programs, as a GPU's compiler gets them.

use super::{Error, Gpu};

impl Gpu {
    /// A program of this crate: no other has loops that are sure to end.
    ///
    /// # Errors
    /// [`Error::Device`].
    #[allow(unsafe_code, reason = "wgpu has no safe way to say that loops end")]
    pub(crate) fn module(&self, label: &str, source: String) -> Result<wgpu::ShaderModule, Error> {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        };
        // Else every loop counts its rounds, lest a stranger's program has one without end: no compiler
        // writes such loops out. Training steps take a sixth longer with it.
        let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..Default::default() };
        // SAFETY: every loop of the files in `shader/wgsl` and `training/wgsl` ends: it counts up to a
        // number that does not change, or a ray moves on by at least one step of finitely many.
        let module = unsafe { self.device.create_shader_module_trusted(descriptor, checks) };
        self.check()?;
        Ok(module)
    }
}
