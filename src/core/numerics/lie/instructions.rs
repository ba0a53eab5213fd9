//! Running code on [`Pack`](super::Pack)s with the matching instruction set.

use super::pack::Lanes;
pub use pulp::NullaryFnOnce as Sweep;

/// The instruction set of a machine for packs. Code is compiled for wide instructions only if it is fully
/// inlined. Therefore a [`Sweep`] is a struct with an `#[inline(always)]` method; closures do not guarantee
/// inlining.
#[derive(Clone, Copy, Debug)]
pub struct Instructions {
    /// 256-bit registers and fused multiply-add. 512-bit instructions are not used: they made the sweeps at
    /// most five percent faster, for a third of all compiled code.
    #[cfg(target_arch = "x86_64")]
    wide: Option<pulp::x86::V3>,
    #[cfg(not(target_arch = "x86_64"))]
    arch: pulp::Arch,
}

impl Instructions {
    /// Instruction set of this machine. Cheap: detection is cached.
    pub fn of_machine() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            wide: pulp::x86::V3::try_new(),
            #[cfg(not(target_arch = "x86_64"))]
            arch: pulp::Arch::new(),
        }
    }

    /// Whether multiply-add is one instruction: true on 64-bit ARM, and on x86-64 with wide registers.
    pub fn has_fused(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        let has_wide = self.wide.is_some();
        #[cfg(not(target_arch = "x86_64"))]
        let has_wide = !matches!(self.arch, pulp::Arch::Scalar);
        has_wide && cfg!(any(target_arch = "x86_64", target_arch = "aarch64"))
    }

    /// Name of the instruction set.
    pub fn name(self) -> &'static str {
        match (self.has_fused(), cfg!(target_arch = "x86_64")) {
            (true, true) => "AVX2 and FMA",
            (true, false) => "NEON",
            (false, _) => "no wide registers",
        }
    }

    /// Whether this build contains sweeps for this machine. Without the feature `portable` it supports only
    /// machines that [have fused instructions](Self::has_fused).
    pub fn are_compiled(self) -> bool {
        cfg!(portable) || self.has_fused()
    }

    /// Runs a sweep on packs of this kind. Panics for fused packs on machines [without fused
    /// instructions](Self::has_fused).
    #[inline(always)]
    pub fn run<P: Lanes, S: Sweep>(self, sweep: S) -> S::Output {
        if !P::FUSED {
            return run_portably(sweep);
        }
        #[cfg(target_arch = "x86_64")]
        return self.wide.expect("a machine with AVX2 and FMA, or the feature `portable`").vectorize(sweep);
        #[cfg(not(target_arch = "x86_64"))]
        self.arch.dispatch(sweep)
    }

    /// Like [`Self::run`], as a separate call within a running sweep, so that rarely needed code takes no
    /// registers from the loops of all robots.
    #[inline(never)]
    pub fn run_outlined<P: Lanes, S: Sweep>(self, sweep: S) -> S::Output {
        self.run::<P, S>(sweep)
    }
}

/// Runs a sweep with the baseline instruction set. Never inlined, so that there is only one copy.
#[inline(never)]
pub fn run_portably<S: Sweep>(sweep: S) -> S::Output {
    sweep.call()
}
