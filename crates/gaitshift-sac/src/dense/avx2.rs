//! The dense product for processors with AVX2 and FMA.
//!
//! Register tiles of 4 rows by 3 vectors of 8 columns: twelve sums in flight cover the latency of the two fused
//! multiply-add units, and sums, vectors and one broadcast fill the sixteen registers. Seven loads for twelve
//! multiply-adds is the least that sixteen registers allow, and loads are what a neighbour on the same core takes
//! away. The vectors that three do not divide go through tiles of 6 rows by 2.

use std::arch::asm;
use std::arch::x86_64::*;

use super::{Epilogue, Product};
use crate::lanes::LANES;

/// Rows that go through all columns before the next ones do: their part of A stays in the first-level cache.
const BLOCK: usize = 24;

/// Vectors of the next strip of tiles when `left` remain: three, because a tile then loads least for its arithmetic,
/// unless a single one would be left over, whose tiles load most.
#[inline(always)]
fn tile_vectors(left: usize) -> usize {
    match left {
        4 => 2,
        _ => left.min(3),
    }
}

/// Rows of the next tile of so many vectors when `left` remain. Twelve sums are in flight in a full tile; a last one of too
/// few to fill the pipeline is avoided.
#[inline(always)]
fn tile_rows(left: usize, vectors: usize) -> usize {
    match (vectors, left) {
        (3, 5 | 6) => 3,
        (3, _) => left.min(4),
        (_, 7 | 8) => 4,
        _ => left.min(6),
    }
}

/// The factor of one row times all vectors, added to the row's sums.
macro_rules! row {
    ($at:literal: $($sum:literal $vector:literal),+) => {
        concat!(
            "vbroadcastss {f}, dword ptr [{a}", $at, "]\n",
            $("vfmadd231ps {", $sum, "}, {f}, {", $vector, "}\n",)+
        )
    };
}

/// One step of a full tile along the shared index.
macro_rules! step {
    (4 by 3) => {
        concat!(
            "vmovups {v0}, ymmword ptr [{b}]\n",
            "vmovups {v1}, ymmword ptr [{b}+32]\n",
            "vmovups {v2}, ymmword ptr [{b}+64]\n",
            row!("": "s0" "v0", "s1" "v1", "s2" "v2"),
            row!("+{row}": "s3" "v0", "s4" "v1", "s5" "v2"),
            row!("+2*{row}": "s6" "v0", "s7" "v1", "s8" "v2"),
            row!("+{row3}": "s9" "v0", "s10" "v1", "s11" "v2"),
            "add {a}, {step}\n",
            "add {b}, {stride}\n",
        )
    };
    (6 by 2) => {
        concat!(
            "vmovups {v0}, ymmword ptr [{b}]\n",
            "vmovups {v1}, ymmword ptr [{b}+32]\n",
            row!("": "s0" "v0", "s1" "v1"),
            row!("+{row}": "s2" "v0", "s3" "v1"),
            row!("+2*{row}": "s4" "v0", "s5" "v1"),
            row!("+{row3}": "s6" "v0", "s7" "v1"),
            row!("+4*{row}": "s8" "v0", "s9" "v1"),
            row!("+{row5}": "s10" "v0", "s11" "v1"),
            "add {a}, {step}\n",
            "add {b}, {stride}\n",
        )
    };
}

/// The loop of a full tile over the shared index, four steps between two jumps: sums[r][v] += Σ factors[r] vectors[v].
/// In assembly, because a full tile needs every register and the compiler, left to itself, spills sums or computes
/// addresses anew; tiles that are not full are rare enough to be left to it.
macro_rules! full_tile {
    ($rows:tt by $vectors:tt, $sums:expr, $product:expr, $a:expr, $b:expr, $($further:tt)*) => {{
        let sums = $sums;
        asm!(
            "sub {n}, 4",
            "jb 3f",
            "2:",
            step!($rows by $vectors),
            step!($rows by $vectors),
            step!($rows by $vectors),
            step!($rows by $vectors),
            "sub {n}, 4",
            "jae 2b",
            "3:",
            "add {n}, 4",
            "jz 5f",
            "4:",
            step!($rows by $vectors),
            "dec {n}",
            "jnz 4b",
            "5:",
            n = inout(reg) $product.shared => _,
            a = inout(reg) $a => _,
            b = inout(reg) $b => _,
            row = in(reg) 4 * $product.a_row,
            row3 = in(reg) 12 * $product.a_row,
            step = in(reg) 4 * $product.a_step,
            stride = in(reg) 4 * $product.b_stride,
            f = out(ymm_reg) _,
            v0 = out(ymm_reg) _,
            v1 = out(ymm_reg) _,
            s0 = inout(ymm_reg) sums[0],
            s1 = inout(ymm_reg) sums[1],
            s2 = inout(ymm_reg) sums[2],
            s3 = inout(ymm_reg) sums[3],
            s4 = inout(ymm_reg) sums[4],
            s5 = inout(ymm_reg) sums[5],
            s6 = inout(ymm_reg) sums[6],
            s7 = inout(ymm_reg) sums[7],
            s8 = inout(ymm_reg) sums[8],
            s9 = inout(ymm_reg) sums[9],
            s10 = inout(ymm_reg) sums[10],
            s11 = inout(ymm_reg) sums[11],
            $($further)*
            options(nostack, readonly),
        )
    }};
}

/// The twelve sums of a full tile, row by row.
#[inline(always)]
fn flat<const R: usize, const V: usize>(sums: &mut [[__m256; V]; R]) -> &mut [__m256; 12] {
    assert!(R * V == 12);
    // SAFETY: an array of arrays lies in memory as one array does.
    unsafe { &mut *(&raw mut *sums).cast() }
}

const NONE: u8 = 0;
const BIAS: u8 = 1;
const BIAS_RELU: u8 = 2;
const MASK: u8 = 3;

/// The tile of so many rows by `V` vectors; [`tile_rows`] gives no others.
macro_rules! dispatch {
    ($rows:expr, $tile:ident::<$($constant:ident),+>($($argument:expr),*)) => {
        match $rows {
            1 => $tile::<1, $($constant),+>($($argument),*),
            2 => $tile::<2, $($constant),+>($($argument),*),
            3 => $tile::<3, $($constant),+>($($argument),*),
            4 => $tile::<4, $($constant),+>($($argument),*),
            5 => $tile::<5, $($constant),+>($($argument),*),
            6 => $tile::<6, $($constant),+>($($argument),*),
            _ => unreachable!(),
        }
    };
}

/// A product whose epilogue is `extra` of the kind that the functions below have as a constant.
#[derive(Clone, Copy)]
struct Raw {
    shared: usize,
    a: *const f32,
    a_row: usize,
    a_step: usize,
    b: *const f32,
    b_stride: usize,
    columns: usize,
    c: *mut f32,
    c_stride: usize,
    extra: *const f32,
    extra_stride: usize,
}

/// # Safety
/// AVX2 and FMA present, `product.check()` passed.
#[target_feature(enable = "avx2,fma")]
pub unsafe fn multiply(product: Product<'_, f32>) {
    let c = product.c.as_mut_ptr();
    let with = |extra, extra_stride| Raw {
        shared: product.shared,
        a: product.a.values.as_ptr(),
        a_row: product.a.row,
        a_step: product.a.step,
        b: product.b.as_ptr(),
        b_stride: product.b_stride,
        columns: product.columns,
        c,
        c_stride: product.c_stride,
        extra,
        extra_stride,
    };
    let rows = product.rows;
    // SAFETY: passed on from the caller.
    unsafe {
        match product.epilogue {
            Epilogue::None => blocks::<NONE>(rows, with(std::ptr::null(), 0)),
            Epilogue::Bias(bias) => blocks::<BIAS>(rows, with(bias.as_ptr(), 0)),
            Epilogue::BiasRelu(bias) => blocks::<BIAS_RELU>(rows, with(bias.as_ptr(), 0)),
            Epilogue::Mask(mask, stride) => blocks::<MASK>(rows, with(mask.as_ptr(), stride)),
        }
    }
}

#[target_feature(enable = "avx2,fma")]
unsafe fn blocks<const E: u8>(rows: usize, product: Raw) {
    for from in (0..rows).step_by(BLOCK) {
        let to = rows.min(from + BLOCK);
        let mut first = 0;
        while first < product.columns {
            let vectors = tile_vectors((product.columns - first) / LANES);
            // SAFETY: passed on from the caller; rows and columns are there.
            unsafe {
                match vectors {
                    3 => strip::<3, E>(from, to, first, product),
                    2 => strip::<2, E>(from, to, first, product),
                    _ => strip::<1, E>(from, to, first, product),
                }
            }
            first += vectors * LANES;
        }
    }
}

/// Rows `from..to` of `V` vectors of columns, the first of which is `first`.
#[inline]
#[target_feature(enable = "avx2,fma")]
unsafe fn strip<const V: usize, const E: u8>(from: usize, to: usize, first: usize, product: Raw) {
    let mut row = from;
    while row < to {
        let rows = tile_rows(to - row, V);
        // SAFETY: the tile lies inside what the caller passed on.
        unsafe { dispatch!(rows, tile::<V, E>(row, first, product)) };
        row += rows;
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
unsafe fn tile<const R: usize, const V: usize, const E: u8>(
    row: usize,
    first: usize,
    product: Raw,
) {
    let Raw {
        a_row,
        a_step,
        b_stride,
        c_stride,
        extra_stride,
        ..
    } = product;
    // SAFETY: the caller's tile lies inside the slices.
    unsafe {
        let a = product.a.add(row * a_row);
        let b = product.b.add(first);
        let c = product.c.add(row * c_stride + first);
        let extra = product.extra.wrapping_add(row * extra_stride + first);
        let mut sums = [[_mm256_setzero_ps(); V]; R];
        if E == BIAS || E == BIAS_RELU {
            for v in 0..V {
                let bias = _mm256_loadu_ps(extra.add(v * LANES));
                for row in &mut sums {
                    row[v] = bias;
                }
            }
        }
        match (R, V) {
            (4, 3) => full_tile!(4 by 3, flat(&mut sums), product, a, b, v2 = out(ymm_reg) _,),
            (6, 2) => full_tile!(
                6 by 2, flat(&mut sums), product, a, b, row5 = in(reg) 20 * a_row,
            ),
            _ => {
                for index in 0..product.shared {
                    for (r, row) in sums.iter_mut().enumerate() {
                        let factor = _mm256_broadcast_ss(&*a.add(r * a_row + index * a_step));
                        for (v, sum) in row.iter_mut().enumerate() {
                            let vector = _mm256_loadu_ps(b.add(index * b_stride + v * LANES));
                            *sum = _mm256_fmadd_ps(factor, vector, *sum);
                        }
                    }
                }
            }
        }
        for (r, row) in sums.iter().enumerate() {
            for (v, &sum) in row.iter().enumerate() {
                let value = match E {
                    // In this order of operands NaN stays NaN and is noticed.
                    BIAS_RELU => _mm256_max_ps(_mm256_setzero_ps(), sum),
                    MASK => {
                        let mask = _mm256_loadu_ps(extra.add(r * extra_stride + v * LANES));
                        _mm256_and_ps(sum, _mm256_cmp_ps::<_CMP_GT_OQ>(mask, _mm256_setzero_ps()))
                    }
                    _ => sum,
                };
                _mm256_storeu_ps(c.add(r * c_stride + v * LANES), value);
            }
        }
    }
}
