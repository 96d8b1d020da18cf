//! Steps swarms on the device: their buffers, the dispatches of their ticks, and the states kept for going back.

use std::sync::Arc;

use bytemuck::bytes_of;
use motion::Method;
use render::wgpu::{
    self, BufferUsages, CommandEncoderDescriptor, ComputePassDescriptor, ShaderStages,
};
use render::{Gpu, RenderError, pipeline_layout, shader_module, uniform};

use crate::log::SwarmTick;
use crate::parameters::Parameters;
use crate::picture::DrawnSwarm;
use crate::swarm::Swarm;

pub(crate) const TICK: &str = include_str!("../shaders/tick.wgsl");
const STEP: &str = include_str!("../shaders/step.wgsl");

/// State of a particle, bytes: two rows of three numbers, and the number of the particle.
const PARTICLE_BYTES: u64 = 2 * ROW_BYTES;
const ROW_BYTES: u64 = 16;

/// Bytes of the velocity with which a particle is born.
const LAUNCH_BYTES: u64 = 12;

/// Time for which a state is kept, s: as far as the program goes back.
const KEPT_S: f64 = 60.0;

/// Least number of ticks between two kept states.
const SPACING: usize = 32;
/// The spacing of kept states is also at least the ticks of the log divided by this number.
const SHARE: usize = 8;

/// Most dispatches that are submitted together.
const DISPATCHES_PER_SUBMIT: usize = 64;

/// Particles per workgroup, as in crates/swarm/shaders/step.wgsl.
const WORKGROUP: u32 = 64;

/// The swarms of a device: those of the last frame.
pub struct Swarms {
    pipelines: [wgpu::ComputePipeline; 2],
    bindings: wgpu::BindGroupLayout,
    /// Parameters of dispatches, each at a multiple of `stride`.
    parameters: wgpu::Buffer,
    stride: u64,
    swarms: Vec<DeviceSwarm>,
    /// Dispatches so far.
    dispatches: u64,
}

/// Index of the pipeline that steps.
const STEPS: usize = 0;
/// Index of the pipeline that synchronizes.
const SYNCHRONIZES: usize = 1;

/// A swarm on the device.
pub(crate) struct DeviceSwarm {
    swarm: Swarm,
    pub rows: Rows,
    /// A bind group for each order of the two rows.
    groups: [wgpu::BindGroup; 2],
    /// Key of the tick whose state it has; `None` before the first.
    key: Option<u64>,
    kept: Vec<Kept>,
    /// Ticks since the last kept state.
    since: usize,
    /// Simulated time since the first frame, s.
    seconds: f64,
    /// The last tick.
    pub last: Option<Parameters>,
}

/// The two rows of each particle: its position, and its last position or its velocity.
pub(crate) struct Rows {
    buffers: [wgpu::Buffer; 2],
    /// Which of the buffers has the positions.
    positions: usize,
}

impl Rows {
    /// `None` if the device has no memory for them.
    fn new(gpu: &Gpu, slots: u64) -> Option<Self> {
        let usage = BufferUsages::STORAGE
            | BufferUsages::VERTEX
            | BufferUsages::COPY_SRC
            | BufferUsages::COPY_DST;
        let buffer = || create(gpu, "swarm", usage, slots * ROW_BYTES);
        Some(Self { buffers: [buffer()?, buffer()?], positions: 0 })
    }

    fn copy(&mut self, from: &Self, encoder: &mut wgpu::CommandEncoder) {
        self.positions = from.positions;
        for (to, from) in self.buffers.iter().zip(&from.buffers) {
            encoder.copy_buffer_to_buffer(from, 0, to, 0, from.size());
        }
    }

    /// Positions, then last positions or velocities.
    pub fn in_order(&self) -> [&wgpu::Buffer; 2] {
        [&self.buffers[self.positions], &self.buffers[1 - self.positions]]
    }
}

/// The state after a tick.
struct Kept {
    key: u64,
    rows: Rows,
    seconds: f64,
}

/// The state of the particle in one slot of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwarmParticle {
    /// The particle's number divided by the number of slots, rounded down.
    pub generation: u64,
    /// Position, m from the anchor.
    pub position: [f32; 3],
    /// Its last position, m from the anchor, or its velocity, m/s.
    pub other: [f32; 3],
}

/// Why an adapter cannot have a swarm.
#[derive(Debug, thiserror::Error)]
pub enum SwarmError {
    /// The adapter runs no compute shaders.
    #[error(
        "the graphics adapter {adapter} runs no compute shaders, which emitters with on: gpu need; give them on: cpu"
    )]
    NoCompute {
        /// The adapter, in one line.
        adapter: String,
    },
    /// The swarm has more particles than the adapter can have in one buffer.
    #[error(
        "{slots} particles are more than the graphics adapter {adapter} can have in one swarm; give an emitter at most {most}, \
         or on: cpu"
    )]
    TooLarge {
        /// The adapter, in one line.
        adapter: String,
        /// Requested number of particles.
        slots: u64,
        /// The most particles that it can have.
        most: u64,
    },
}

impl Swarms {
    /// Whether the adapter of `gpu` can have a swarm of `slots` particles.
    ///
    /// # Errors
    /// If it has no compute shaders, or its buffers or dispatches are too small.
    pub fn check(gpu: &Gpu, slots: u64) -> Result<(), SwarmError> {
        let adapter = || gpu.info.to_string();
        let flags = gpu.adapter.get_downlevel_capabilities().flags;
        if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
            return Err(SwarmError::NoCompute { adapter: adapter() });
        }
        let limits = gpu.device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let groups = u64::from(limits.max_compute_workgroups_per_dimension) * u64::from(WORKGROUP);
        let most = (bytes / ROW_BYTES).min(groups);
        if slots > most {
            return Err(SwarmError::TooLarge { adapter: adapter(), slots, most });
        }
        Ok(())
    }

    /// Creates an empty set of swarms, on a device that can have them: see [`Swarms::check`].
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let entry = |binding, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None },
            ..uniform(binding, ShaderStages::COMPUTE)
        };
        let storage = |binding, read_only| {
            entry(binding, wgpu::BufferBindingType::Storage { read_only }, false)
        };
        let bindings = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("swarm"),
            entries: &[
                entry(0, wgpu::BufferBindingType::Uniform, true),
                storage(1, false),
                storage(2, false),
                storage(3, true),
            ],
        });
        let layout = pipeline_layout(device, "swarm", &[Some(&bindings)]);
        let shader = shader_module(device, "swarm", &[TICK, STEP]);
        let pipeline = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&layout),
                module: &shader,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let stride = (size_of::<Parameters>() as u64).next_multiple_of(alignment);
        Self {
            pipelines: [pipeline("step"), pipeline("synchronize")],
            bindings,
            parameters: buffer(
                gpu,
                "swarm parameters",
                BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                stride * DISPATCHES_PER_SUBMIT as u64,
            ),
            stride,
            swarms: Vec::new(),
            dispatches: 0,
        }
    }

    /// Dispatches so far.
    #[must_use]
    pub const fn dispatches(&self) -> u64 {
        self.dispatches
    }

    /// Advances the device to the last tick of each of `swarms`, and drops all other swarms. Submits the work without
    /// waiting for it.
    pub fn follow(&mut self, gpu: &Gpu, swarms: &[DrawnSwarm]) {
        let is = |device: &DeviceSwarm, DrawnSwarm { swarm, .. }: &DrawnSwarm| {
            Arc::ptr_eq(&device.swarm.launches, &swarm.launches)
                && device.swarm.method == swarm.method
        };
        self.swarms.retain(|device| swarms.iter().any(|swarm| is(device, swarm)));
        for swarm in swarms {
            let place = self.swarms.iter().position(|device| is(device, swarm));
            let device = match place {
                Some(place) => Some(self.swarms.remove(place)),
                None => DeviceSwarm::new(gpu, self, &swarm.swarm),
            };
            let Some(mut device) = device else {
                let particles = swarm.swarm.slots();
                gpu.give_up(format!(
                    "it has no memory for {particles} particles of an emitter with on: gpu"
                ));
                continue;
            };
            let most = if swarm.goes_back { Swarm::KEPT_BYTES / swarms.len() as u64 } else { 0 };
            self.follow_one(gpu, &mut device, swarm, most);
            self.swarms.push(device);
        }
    }

    /// The swarms on the device, in the order of the swarms given to [`Self::follow`].
    pub(crate) fn devices(&self) -> &[DeviceSwarm] {
        &self.swarms
    }

    fn follow_one(
        &mut self,
        gpu: &Gpu,
        device: &mut DeviceSwarm,
        swarm: &DrawnSwarm,
        most_kept: u64,
    ) {
        let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
        let here = swarm.ticks.iter().rposition(|tick| Some(tick.key) == device.key);
        // Only states ahead of the device help. In a run that is not sought, one tick is ahead.
        let ahead = swarm.ticks.iter().enumerate().skip(here.map_or(0, |here| here + 1)).rev();
        let kept_of = |tick: &SwarmTick| device.kept.iter().find(|kept| kept.key == tick.key);
        let kept = { ahead }.find_map(|(at, tick)| Some((at, kept_of(tick)?)));
        let begins = kept.as_ref().map(|(at, _)| *at).or(here);
        if let Some((_, kept)) = kept {
            device.rows.copy(&kept.rows, &mut encoder);
            (device.seconds, device.since) = (kept.seconds, 0);
        } else if here.is_none() {
            device.rows.buffers.iter().for_each(|buffer| encoder.clear_buffer(buffer, 0, None));
        }
        let and_before = |place: usize| {
            (&swarm.ticks[place], place.checked_sub(1).map(|before| &swarm.ticks[before]))
        };
        if let Some(begins) = begins {
            // Needed even if no tick follows.
            device.last = Some(device.parameters(and_before(begins)));
        }
        let first = begins.map_or(0, |begins| begins + 1);
        let mut work = Work { encoder, dispatches: Vec::new() };
        for place in first..swarm.ticks.len() {
            self.tick(gpu, device, &mut work, and_before(place));
            device.keep(
                gpu,
                self,
                &mut work,
                (swarm.ticks[place].key, swarm.ticks.len()),
                most_kept,
            );
        }
        self.submit(gpu, device, work);
        device.key = swarm.ticks.last().map(|tick| tick.key);
        if device.key.is_none() {
            device.last = None;
        }
    }

    /// Adds the dispatches of a tick to `work`; `last` is the tick before.
    fn tick(
        &mut self,
        gpu: &Gpu,
        device: &mut DeviceSwarm,
        work: &mut Work,
        (tick, last): (&SwarmTick, Option<&SwarmTick>),
    ) {
        let parameters = device.parameters((tick, last));
        let swaps = device.swarm.method == Method::PositionVerlet;
        if let Some(last) = last.filter(|_| tick.other_laws && swaps) {
            // Gusts are evaluated at the end of the last tick, as the shader does.
            let parameters = parameters.under(&last.laws, last.phase);
            self.dispatch(gpu, device, work, (SYNCHRONIZES, parameters));
        }
        for substep in 0..tick.substeps {
            let mut at = parameters;
            at.substep = substep;
            self.dispatch(gpu, device, work, (STEPS, at));
            if swaps {
                device.rows.positions = 1 - device.rows.positions;
            }
        }
        device.last = Some(parameters);
        device.seconds += f64::from(tick.step);
    }

    fn dispatch(
        &mut self,
        gpu: &Gpu,
        device: &DeviceSwarm,
        work: &mut Work,
        (pipeline, parameters): (usize, Parameters),
    ) {
        if work.dispatches.len() == DISPATCHES_PER_SUBMIT {
            let encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
            let full = std::mem::replace(work, Work { encoder, dispatches: Vec::new() });
            self.submit(gpu, device, full);
        }
        work.dispatches.push((pipeline, device.rows.positions, parameters));
    }

    /// Encodes the dispatches of `work`, and submits it.
    fn submit(&mut self, gpu: &Gpu, device: &DeviceSwarm, mut work: Work) {
        if !work.dispatches.is_empty() {
            let groups = device.slots().div_ceil(WORKGROUP);
            let mut pass = work.encoder.begin_compute_pass(&ComputePassDescriptor::default());
            for (place, (pipeline, positions, parameters)) in (0..).zip(work.dispatches) {
                let offset = self.stride * place;
                gpu.queue.write_buffer(&self.parameters, offset, bytes_of(&parameters));
                pass.set_pipeline(&self.pipelines[pipeline]);
                pass.set_bind_group(0, &device.groups[positions], &[offset as u32]);
                pass.dispatch_workgroups(groups, 1, 1);
                self.dispatches += 1;
            }
        }
        gpu.queue.submit([work.encoder.finish()]);
    }

    /// Reads the particles in all slots of swarm number `index` of the swarms on the device; `None` for a slot
    /// without a particle. Waits for the device.
    ///
    /// # Errors
    /// If it cannot be read back.
    pub fn read(&self, gpu: &Gpu, index: usize) -> Result<Vec<Option<SwarmParticle>>, RenderError> {
        let Some(swarm) = self.swarms.get(index) else { return Ok(Vec::new()) };
        let [positions, others] = swarm.rows.in_order();
        let (positions, others) = (read_rows(gpu, positions)?, read_rows(gpu, others)?);
        let particle = |([x, y, z, number], [u, v, w, _]): ([u32; 4], [u32; 4])| {
            let generation = u64::from(number.checked_sub(1)?);
            let [position, other] = [[x, y, z], [u, v, w]].map(|row| row.map(f32::from_bits));
            Some(SwarmParticle { generation, position, other })
        };
        Ok(positions.into_iter().zip(others).map(particle).collect())
    }
}

/// Commands, and dispatches to be encoded after them: pipeline, order of the rows, parameters.
struct Work {
    encoder: wgpu::CommandEncoder,
    dispatches: Vec<(usize, usize, Parameters)>,
}

impl DeviceSwarm {
    /// `None` if the device has no memory for it.
    fn new(gpu: &Gpu, swarms: &Swarms, swarm: &Swarm) -> Option<Self> {
        let device = &gpu.device;
        let slots = swarm.slots();
        let rows = Rows::new(gpu, slots)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let launches = create(gpu, "launches", usage, slots * LAUNCH_BYTES)?;
        gpu.queue.write_buffer(&launches, 0, bytemuck::cast_slice(&swarm.launches));
        let group = |positions: usize| {
            let parameters = wgpu::BufferBinding {
                buffer: &swarms.parameters,
                offset: 0,
                size: wgpu::BufferSize::new(size_of::<Parameters>() as u64),
            };
            let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("swarm"),
                layout: &swarms.bindings,
                entries: &[
                    entry(0, wgpu::BindingResource::Buffer(parameters)),
                    entry(1, rows.buffers[positions].as_entire_binding()),
                    entry(2, rows.buffers[1 - positions].as_entire_binding()),
                    entry(3, launches.as_entire_binding()),
                ],
            })
        };
        Some(Self {
            swarm: swarm.clone(),
            groups: [group(0), group(1)],
            rows,
            key: None,
            kept: Vec::new(),
            since: 0,
            seconds: 0.0,
            last: None,
        })
    }

    /// The parameters of a tick after `last`.
    fn parameters(&self, (tick, last): (&SwarmTick, Option<&SwarmTick>)) -> Parameters {
        Parameters::new(self.swarm.method, self.slots(), tick, last)
    }

    pub fn slots(&self) -> u32 {
        self.swarm.slots() as u32
    }

    /// Keeps the state after the tick `key` of a log of `ticks` ticks, if the last kept state is old enough. The
    /// oldest is dropped if there is no room: a state further back than the log reaches is computed from the log's
    /// beginning.
    fn keep(
        &mut self,
        gpu: &Gpu,
        swarms: &mut Swarms,
        work: &mut Work,
        (key, ticks): (u64, usize),
        most: u64,
    ) {
        self.since += 1;
        let bytes = u64::from(self.slots()) * PARTICLE_BYTES;
        if self.since < SPACING.max(ticks / SHARE) || bytes > most {
            return;
        }
        self.since = 0;
        self.kept.retain(|kept| self.seconds - kept.seconds < KEPT_S && kept.key != key);
        if (self.kept.len() as u64 + 1) * bytes > most {
            self.kept.remove(0);
        }
        let Some(mut rows) = Rows::new(gpu, u64::from(self.slots())) else { return };
        // Copied after the dispatches before it are done.
        let encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
        let before = std::mem::replace(work, Work { encoder, dispatches: Vec::new() });
        swarms.submit(gpu, self, before);
        rows.copy(&self.rows, &mut work.encoder);
        self.kept.push(Kept { key, rows, seconds: self.seconds });
    }
}

pub(crate) fn buffer(gpu: &Gpu, label: &str, usage: BufferUsages, size: u64) -> wgpu::Buffer {
    let label = Some(label);
    let descriptor = wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false };
    gpu.device.create_buffer(&descriptor)
}

/// A buffer; `None` if the device has no memory for it.
fn create(gpu: &Gpu, label: &str, usage: BufferUsages, size: u64) -> Option<wgpu::Buffer> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let buffer = buffer(gpu, label, usage, size);
    render::caught(scope).is_none().then_some(buffer)
}

/// Reads the rows of a buffer. Waits for the device.
fn read_rows(gpu: &Gpu, rows: &wgpu::Buffer) -> Result<Vec<[u32; 4]>, RenderError> {
    let failed = |detail: String| RenderError::ReadBack { detail };
    let usage = BufferUsages::COPY_DST | BufferUsages::MAP_READ;
    let target = buffer(gpu, "read back", usage, rows.size());
    let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(rows, 0, &target, 0, rows.size());
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&target).map_err(failed)?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}
