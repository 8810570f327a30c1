//! Nodes to lanes: records of four numbers transposed into columns.
//! Never here: arithmetic.

use super::LANES;
use super::block::Nodes;
use crate::state::nodes::Node;

/// The token of four-lane shuffles, where the machine has them.
#[cfg(target_arch = "x86_64")]
pub type Wide = Option<pulp::x86::V3>;
/// The token of four-lane shuffles, where the machine has them.
#[cfg(not(target_arch = "x86_64"))]
pub type Wide = ();

/// What the machine has.
#[cfg(target_arch = "x86_64")]
pub fn wide() -> Wide {
    pulp::x86::V3::try_new()
}

/// What the machine has.
#[cfg(not(target_arch = "x86_64"))]
pub fn wide() -> Wide {}

/// Copies the nodes of a block beside each other. By hand, because compilers would use gather instructions where the
/// vectors are wide, and single loads where they are not: both are slower than a transposition in registers.
#[inline(always)]
pub fn collect(wide: Wide, nodes: &[Node], of: &[[u32; LANES]; 4], to: &mut Nodes) {
    for (corner, of) in of.iter().enumerate() {
        let columns = [&mut to.r[corner], &mut to.z[corner], &mut to.v_r[corner], &mut to.v_z[corner]];
        let [r, z, v_r, v_z] = columns.map(|c| c.as_chunks_mut::<4>().0);
        for (i, four) in of.as_chunks::<4>().0.iter().enumerate() {
            let records = four.map(|n| nodes[n as usize].as_array());
            [r[i], z[i], v_r[i], v_z[i]] = transpose(wide, records);
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose(wide: Wide, rows: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let Some(v3) = wide else { return plain(rows) };
    let [a, b, c, d] = rows.map(pulp::cast);
    let avx = v3.avx;
    let (low_ab, high_ab) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
    let (low_cd, high_cd) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
    [
        avx._mm256_permute2f128_pd::<0x20>(low_ab, low_cd),
        avx._mm256_permute2f128_pd::<0x20>(high_ab, high_cd),
        avx._mm256_permute2f128_pd::<0x31>(low_ab, low_cd),
        avx._mm256_permute2f128_pd::<0x31>(high_ab, high_cd),
    ]
    .map(pulp::cast)
}

#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
fn transpose(_wide: Wide, rows: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    plain(rows)
}

#[inline(always)]
fn plain(rows: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|column| rows.map(|row| row[column]))
}

#[cfg(test)]
mod tests {
    use super::{plain, transpose, wide};

    #[test]
    fn shuffles_transpose() {
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| (4 * i + j) as f64));
        assert_eq!(transpose(wide(), rows), plain(rows));
        assert_eq!(plain(rows)[2], [2.0, 6.0, 10.0, 14.0]);
    }
}
