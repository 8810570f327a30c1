//! Which instruction set elements use, where it is not left to the machine.
//! Never here: arithmetic, which is the same on all.

use std::str::FromStr;

use pulp::Arch;

use super::elements::Elements;

/// An instruction set. All give the same bits; the machine's best is the default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// One number at a time, as far as the compiler leaves it so.
    Scalar,
    /// Four numbers at a time (x86-64-v3).
    Avx2,
    /// Eight numbers at a time (x86-64-v4).
    Avx512,
}

/// A word that names no instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("scalar, avx2 and avx512 are known")]
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
    /// The set; `None` where the machine does not have it.
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

impl Elements {
    /// Uses an instruction set from now on.
    pub fn use_arch(&mut self, arch: Arch) {
        self.groups.iter_mut().for_each(|group| group.extensions().settings().use_instructions(arch));
    }
}
