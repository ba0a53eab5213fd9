//! Running code on [`Pack`](super::Pack)s with the matching instruction set.

use super::pack::Lanes;
pub use pulp::NullaryFnOnce as Sweep;

/// What a machine can do with packs. Code that runs with wide instructions is compiled for them where all of it is
/// inlined. A [`Sweep`] is therefore a struct with an `#[inline(always)]` method: a closure does not promise that.
#[derive(Clone, Copy, Debug)]
pub struct Instructions {
    /// 256-bit registers and fused multiply-add. The 512-bit instructions are left alone: the sweeps were at most five
    /// percent faster with them, and a third of all compiled code was theirs.
    #[cfg(target_arch = "x86_64")]
    wide: Option<pulp::x86::V3>,
    #[cfg(not(target_arch = "x86_64"))]
    arch: pulp::Arch,
}

impl Instructions {
    /// Those of this machine. Cheap: what was found is kept.
    pub fn of_machine() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            wide: pulp::x86::V3::try_new(),
            #[cfg(not(target_arch = "x86_64"))]
            arch: pulp::Arch::new(),
        }
    }

    /// Whether multiplying and adding is one instruction: on 64-bit ARM it is, and on x86-64 with wide registers.
    pub fn has_fused(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        let has_wide = self.wide.is_some();
        #[cfg(not(target_arch = "x86_64"))]
        let has_wide = !matches!(self.arch, pulp::Arch::Scalar);
        has_wide && cfg!(any(target_arch = "x86_64", target_arch = "aarch64"))
    }

    /// The name of the instruction set.
    pub fn name(self) -> &'static str {
        match (self.has_fused(), cfg!(target_arch = "x86_64")) {
            (true, true) => "AVX2 and FMA",
            (true, false) => "NEON",
            (false, _) => "no wide registers",
        }
    }

    /// Whether this build has sweeps for this machine: without the feature `portable`, only machines that
    /// [have fused instructions](Self::has_fused) are served.
    pub fn are_compiled(self) -> bool {
        cfg!(feature = "portable") || self.has_fused()
    }

    /// Runs what works on packs of this kind. Packs that are fused are for machines that [have that](Self::has_fused):
    /// elsewhere this panics.
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

    /// [`Self::run`] as a call of its own within a sweep that runs already: what few robots need then costs the loops
    /// of all others no registers.
    #[inline(never)]
    pub fn run_apart<P: Lanes, S: Sweep>(self, sweep: S) -> S::Output {
        self.run::<P, S>(sweep)
    }
}

/// Runs a sweep with the instructions that all machines have. Never inlined: these copies are only needed once.
#[inline(never)]
pub fn run_portably<S: Sweep>(sweep: S) -> S::Output {
    sweep.call()
}
