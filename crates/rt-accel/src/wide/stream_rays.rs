//! Rays of a stream, in lanes or one by one.

use core::cell::OnceCell;

use rt_geometry::{RayStream, STREAM_CAPACITY, StreamArray};
use rt_math::{Interval, Ray};

use super::f64x8::{F64x8, PACKET};
use super::ray_soa::RaySoa8;
use super::simd::Simd;

/// Packets of a stream.
pub(super) const N_PACKETS: usize = STREAM_CAPACITY / PACKET;

/// Mask with a bit for each packet of a stream.
pub(super) const ALL_PACKETS: u32 = !0;
const _: () = assert!(N_PACKETS == 32, "a bit for each packet");

/// Eight rays as an array of structures.
type Packet = [(Ray, Interval); PACKET];

/// Copies of packets, for rays that are traced one by one.
pub(super) type PacketCopies = [OnceCell<Packet>; N_PACKETS];

/// Rays of a stream. Packets begin at multiples of [`PACKET`].
#[derive(Clone, Copy)]
pub(super) struct StreamRays<'r> {
    rays: &'r RayStream,
    copies: &'r PacketCopies,
}

impl<'r> StreamRays<'r> {
    pub(super) const fn new(rays: &'r RayStream, copies: &'r PacketCopies) -> Self {
        Self { rays, copies }
    }

    pub(super) const fn len(self) -> usize {
        self.rays.len()
    }

    /// The ray of an index below the length.
    #[inline(always)]
    pub(super) fn get(self, at: usize) -> &'r (Ray, Interval) {
        self.packet(at / PACKET * PACKET).get(at % PACKET)
    }

    /// The packet that begins at an index.
    #[inline(always)]
    pub(super) const fn packet(self, first: usize) -> PacketRays<'r> {
        PacketRays { stream: self, first }
    }

    /// Directions of the packet that begins at an index. Those behind the last ray have no meaning.
    #[inline(always)]
    pub(super) fn directions<S: Simd>(self, simd: S, first: usize) -> [F64x8<S>; 3] {
        let [x, y, z] = &self.rays.direction;
        [load(simd, x, first), load(simd, y, first), load(simd, z, first)]
    }

    /// A number of each ray of the packet that begins at an index.
    #[inline(always)]
    pub(super) fn numbers<S: Simd>(
        self,
        simd: S,
        first: usize,
        of_stream: impl Fn(&RayStream) -> &StreamArray<f64>,
    ) -> F64x8<S> {
        load(simd, of_stream(self.rays), first)
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, numbers: &StreamArray<f64>, first: usize) -> F64x8<S> {
    F64x8::new(simd, *numbers.vector(first))
}

/// Eight rays of a stream, or fewer at its end.
#[derive(Clone, Copy)]
pub(super) struct PacketRays<'r> {
    stream: StreamRays<'r>,
    first: usize,
}

impl<'r> PacketRays<'r> {
    /// The rays in lanes, padded with copies of the first.
    #[inline(always)]
    pub(super) fn soa<S: Simd>(self, simd: S) -> RaySoa8<S> {
        let StreamRays { rays, .. } = self.stream;
        if self.first + PACKET <= rays.len() {
            RaySoa8::load(simd, rays, self.first, true)
        } else {
            RaySoa8::new(simd, self.all())
        }
    }

    /// The rays as an array of structures, padded with copies of the first.
    #[inline(always)]
    pub(super) fn all(self) -> &'r Packet {
        let StreamRays { rays, copies } = self.stream;
        let packet = &copies[self.first / PACKET % N_PACKETS];
        match packet.get() {
            Some(packet) => packet,
            None => copied(rays, self.first, packet),
        }
    }

    #[inline(always)]
    pub(super) fn get(self, lane: usize) -> &'r (Ray, Interval) {
        &self.all()[lane % PACKET]
    }
}

/// Copies a packet of a stream. Compiled once.
#[inline(never)]
fn copied<'r>(rays: &RayStream, first: usize, packet: &'r OnceCell<Packet>) -> &'r Packet {
    packet.get_or_init(|| {
        let n = rays.len().saturating_sub(first);
        core::array::from_fn(|lane| rays.get(if lane < n { first + lane } else { first }))
    })
}
