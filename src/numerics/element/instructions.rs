//! Choice of the instruction set of element updates.

use std::str::FromStr;

use pulp::Arch;

/// An instruction set. All sets give the same bits; the default is the best of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// Scalar code, apart from vectorization by the compiler.
    Scalar,
    /// Four numbers at a time (x86-64-v3).
    Avx2,
    /// Eight numbers at a time (x86-64-v4).
    Avx512,
}

/// Error: the name of an instruction set is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown instruction set; allowed: scalar, avx2, avx512")]
pub struct UnknownInstructions;

impl FromStr for Instructions {
    type Err = UnknownInstructions;

    fn from_str(text: &str) -> Result<Self, UnknownInstructions> {
        match text {
            "scalar" => Ok(Instructions::Scalar),
            "avx2" => Ok(Instructions::Avx2),
            "avx512" => Ok(Instructions::Avx512),
            _ => Err(UnknownInstructions),
        }
    }
}

impl Instructions {
    /// Returns the instruction set for dispatch; `None` if the machine does not support it.
    pub fn arch(self) -> Option<Arch> {
        match self {
            Instructions::Scalar => Some(Arch::Scalar),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => pulp::x86::V3::try_new().map(Arch::V3),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => pulp::x86::V4::try_new().map(Arch::V4),
            #[cfg(not(target_arch = "x86_64"))]
            _ => None,
        }
    }
}
