//! The products for processors with AVX2 and FMA.
//!
//! Register tiles of 4 rows by 3 panels, a vector each: twelve sums in flight cover the latency of the two fused
//! multiply-add units, and sums, weights and one broadcast fill the sixteen registers. Seven loads for twelve
//! multiply-adds is the least that sixteen registers allow, and loads are what a neighbour on the same core takes
//! away. The panels that three do not divide go through tiles of 6 rows by 2.

use std::arch::asm;
use std::arch::x86_64::*;

use super::{Epilogue, MatMul, Outer, PANEL};

/// Rows that go through all panels before the next ones do: their part of X stays in the first-level cache beside a
/// few panels, and the panels stream past in the order they lie in memory.
const BLOCK: usize = 24;

/// Panels of the next strip of tiles when `left` remain: three, because a tile then loads least for its arithmetic, unless
/// a single panel would be left over, whose tiles load most.
#[inline(always)]
fn tile_panels(left: usize) -> usize {
    match left {
        4 => 2,
        _ => left.min(3),
    }
}

/// Rows of the next tile of so many panels when `left` remain. Twelve sums are in flight in a full tile; a last one of too
/// few to fill the pipeline is avoided.
#[inline(always)]
fn tile_rows(left: usize, panels: usize) -> usize {
    match (panels, left) {
        (3, 5 | 6) => 3,
        (3, _) => left.min(4),
        (_, 7 | 8) => 4,
        _ => left.min(6),
    }
}

/// One factor times all vectors, added to its sums.
macro_rules! factor {
    ($at:literal $shift:literal: $($sum:literal $vector:literal),+) => {
        concat!(
            "vbroadcastss {f}, dword ptr [", $at, $shift, "]\n",
            $("vfmadd231ps {", $sum, "}, {f}, {", $vector, "}\n",)+
        )
    };
}

/// One step of a full tile: where its vectors lie and how far the step shifts that, then the same of its factors.
macro_rules! step {
    ([$v0:literal $v1:literal $v2:literal] $w:literal, [$f0:literal $f1:literal $f2:literal $f3:literal] $x:literal) => {
        concat!(
            "vmovups {v0}, ymmword ptr [", $v0, $w, "]\n",
            "vmovups {v1}, ymmword ptr [", $v1, $w, "]\n",
            "vmovups {v2}, ymmword ptr [", $v2, $w, "]\n",
            factor!($f0 $x: "s0" "v0", "s1" "v1", "s2" "v2"),
            factor!($f1 $x: "s3" "v0", "s4" "v1", "s5" "v2"),
            factor!($f2 $x: "s6" "v0", "s7" "v1", "s8" "v2"),
            factor!($f3 $x: "s9" "v0", "s10" "v1", "s11" "v2"),
        )
    };
    (
        [$v0:literal $v1:literal] $w:literal,
        [$f0:literal $f1:literal $f2:literal $f3:literal $f4:literal $f5:literal] $x:literal
    ) => {
        concat!(
            "vmovups {v0}, ymmword ptr [", $v0, $w, "]\n",
            "vmovups {v1}, ymmword ptr [", $v1, $w, "]\n",
            factor!($f0 $x: "s0" "v0", "s1" "v1"),
            factor!($f1 $x: "s2" "v0", "s3" "v1"),
            factor!($f2 $x: "s4" "v0", "s5" "v1"),
            factor!($f3 $x: "s6" "v0", "s7" "v1"),
            factor!($f4 $x: "s8" "v0", "s9" "v1"),
            factor!($f5 $x: "s10" "v0", "s11" "v1"),
        )
    };
}

/// The loop of a full tile over the shared index, four steps between two jumps: sums[r][p] += Σ factors[r] vectors[p].
/// `{x}` and `{w}` move along the factors and the vectors, `{s}` and `{t}` are distances there in bytes. `four` and `one`
/// are the steps, by their shifts of vectors and factors, with the instructions that move on. In assembly, because a full
/// tile needs every register and the compiler, left to itself, spills sums or computes addresses anew; tiles that are
/// not full are rare enough to be left to it.
macro_rules! full_tile {
    (
        $sums:expr, $count:expr, x: $x:expr, $s:expr, w: $w:expr, $t:expr,
        vectors: $vectors:tt, factors: $factors:tt,
        four: { $($(($four_w:literal $four_x:literal))+ then $($four_move:literal)+;)+ }
        one: { ($one_w:literal $one_x:literal) then $($one_move:literal)+; }
        $($further:tt)*
    ) => {{
        let sums = $sums;
        asm!(
            "sub {n}, 4",
            "jb 3f",
            "2:",
            $($(step!($vectors $four_w, $factors $four_x),)+ $($four_move,)+)+
            "sub {n}, 4",
            "jae 2b",
            "3:",
            "add {n}, 4",
            "jz 5f",
            "4:",
            step!($vectors $one_w, $factors $one_x),
            $($one_move,)+
            "dec {n}",
            "jnz 4b",
            "5:",
            n = inout(reg) $count => _,
            x = inout(reg) $x => _,
            w = inout(reg) $w => _,
            s = in(reg) 4 * $s,
            t = in(reg) 4 * $t,
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
fn flat<const R: usize, const P: usize>(sums: &mut [[__m256; P]; R]) -> &mut [__m256; 12] {
    assert!(R * P == 12);
    // SAFETY: an array of arrays lies in memory as one array does.
    unsafe { &mut *(&raw mut *sums).cast() }
}

const NONE: u8 = 0;
const BIAS: u8 = 1;
const BIAS_RELU: u8 = 2;
const MASK: u8 = 3;

/// The tile of so many rows by `P` panels; [`tile_rows`] gives no others.
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
struct Product {
    k: usize,
    x: *const f32,
    x_stride: usize,
    panels: *const f32,
    columns: usize,
    y: *mut f32,
    y_stride: usize,
    extra: *const f32,
    extra_stride: usize,
}

/// # Safety
/// AVX2 and FMA present, `product.check()` passed.
#[target_feature(enable = "avx2,fma")]
pub unsafe fn matmul(product: MatMul<'_, f32>) {
    let y = product.y.as_mut_ptr();
    let with = |extra, extra_stride| Product {
        k: product.k,
        x: product.x.as_ptr(),
        x_stride: product.x_stride,
        panels: product.panels.as_ptr(),
        columns: product.columns,
        y,
        y_stride: product.y_stride,
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
unsafe fn blocks<const E: u8>(rows: usize, product: Product) {
    for from in (0..rows).step_by(BLOCK) {
        let to = rows.min(from + BLOCK);
        let mut first = 0;
        while first < product.columns {
            let panels = tile_panels((product.columns - first) / PANEL);
            // SAFETY: passed on from the caller; rows and panels are there.
            unsafe {
                match panels {
                    3 => strip::<3, E>(from, to, first, product),
                    2 => strip::<2, E>(from, to, first, product),
                    _ => strip::<1, E>(from, to, first, product),
                }
            }
            first += panels * PANEL;
        }
    }
}

/// Rows `from..to` of `P` panels, whose first column is `first`.
#[inline]
#[target_feature(enable = "avx2,fma")]
unsafe fn strip<const P: usize, const E: u8>(
    from: usize,
    to: usize,
    first: usize,
    product: Product,
) {
    let mut row = from;
    while row < to {
        let rows = tile_rows(to - row, P);
        // SAFETY: the tile lies inside what the caller passed on.
        unsafe { dispatch!(rows, tile::<P, E>(row, first, product)) };
        row += rows;
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
unsafe fn tile<const R: usize, const P: usize, const E: u8>(
    row: usize,
    first: usize,
    product: Product,
) {
    let Product {
        k,
        x_stride,
        y_stride,
        extra_stride,
        ..
    } = product;
    // SAFETY: the caller's tile lies inside the slices.
    unsafe {
        let x = product.x.add(row * x_stride);
        let panels = product.panels.add(first * k);
        let y = product.y.add(row * y_stride + first);
        let extra = product.extra.wrapping_add(row * extra_stride + first);
        let mut sums = [[_mm256_setzero_ps(); P]; R];
        if E == BIAS || E == BIAS_RELU {
            for p in 0..P {
                let bias = _mm256_loadu_ps(extra.add(p * PANEL));
                for row in &mut sums {
                    row[p] = bias;
                }
            }
        }
        match (R, P) {
            (4, 3) => full_tile!(
                flat(&mut sums), k, x: x, x_stride, w: panels, k * PANEL,
                vectors: ["{w}" "{w}+{t}" "{w}+2*{t}"],
                factors: ["{x}" "{x}+{s}" "{x}+2*{s}" "{x}+{u}"],
                four: { ("" "") ("+32" "+4") ("+64" "+8") ("+96" "+12") then "add {x}, 16" "add {w}, 128"; }
                one: { ("" "") then "add {x}, 4" "add {w}, 32"; }
                u = in(reg) 12 * x_stride,
                v2 = out(ymm_reg) _,
            ),
            // Rows are counted from the second.
            (6, 2) => full_tile!(
                flat(&mut sums), k, x: x.add(x_stride), x_stride, w: panels, k * PANEL,
                vectors: ["{w}" "{w}+{t}"],
                factors: ["{x}+{z}" "{x}" "{x}+{s}" "{x}+2*{s}" "{x}+{u}" "{x}+4*{s}"],
                four: { ("" "") ("+32" "+4") ("+64" "+8") ("+96" "+12") then "add {x}, 16" "add {w}, 128"; }
                one: { ("" "") then "add {x}, 4" "add {w}, 32"; }
                u = in(reg) 12 * x_stride,
                z = in(reg) (4 * x_stride).wrapping_neg(),
            ),
            _ => {
                for index in 0..k {
                    for (r, row) in sums.iter_mut().enumerate() {
                        let factor = _mm256_broadcast_ss(&*x.add(r * x_stride + index));
                        for (p, sum) in row.iter_mut().enumerate() {
                            let weights = _mm256_loadu_ps(panels.add((p * k + index) * PANEL));
                            *sum = _mm256_fmadd_ps(factor, weights, *sum);
                        }
                    }
                }
            }
        }
        for (r, row) in sums.iter().enumerate() {
            for (p, &sum) in row.iter().enumerate() {
                let value = match E {
                    // In this order of operands NaN stays NaN and is noticed.
                    BIAS_RELU => _mm256_max_ps(_mm256_setzero_ps(), sum),
                    MASK => {
                        let mask = _mm256_loadu_ps(extra.add(r * extra_stride + p * PANEL));
                        _mm256_and_ps(sum, _mm256_cmp_ps::<_CMP_GT_OQ>(mask, _mm256_setzero_ps()))
                    }
                    _ => sum,
                };
                _mm256_storeu_ps(y.add(r * y_stride + p * PANEL), value);
            }
        }
    }
}

/// # Safety
/// AVX2 and FMA present, `product.check()` passed.
#[target_feature(enable = "avx2,fma")]
pub unsafe fn outer(mut product: Outer<'_, f32>) {
    let mut first = 0;
    while first < product.columns {
        let panels = tile_panels((product.columns - first) / PANEL);
        // SAFETY: passed on from the caller; the panels are there.
        unsafe {
            match panels {
                3 => outer_strip::<3>(first, &mut product),
                2 => outer_strip::<2>(first, &mut product),
                _ => outer_strip::<1>(first, &mut product),
            }
        }
        first += panels * PANEL;
    }
}

/// `P` panels, whose first column is `first`.
#[inline]
#[target_feature(enable = "avx2,fma")]
unsafe fn outer_strip<const P: usize>(first: usize, product: &mut Outer<'_, f32>) {
    let mut index = 0;
    while index < product.k {
        let rows = tile_rows(product.k - index, P);
        // SAFETY: the tile lies inside what the caller passed on.
        unsafe { dispatch!(rows, outer_tile::<P>(index, first, product)) };
        index += rows;
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
unsafe fn outer_tile<const R: usize, const P: usize>(
    index: usize,
    first: usize,
    product: &mut Outer<'_, f32>,
) {
    let Outer {
        rows,
        k,
        x_stride,
        y_stride,
        ..
    } = *product;
    // SAFETY: the caller's tile lies inside the slices.
    unsafe {
        let x = product.x.as_ptr().add(index);
        let y = product.y.as_ptr().add(first);
        let out = product.panels.as_mut_ptr().add(first * k + index * PANEL);
        let mut sums = [[_mm256_setzero_ps(); P]; R];
        match (R, P) {
            (4, 3) => full_tile!(
                flat(&mut sums), rows, x: x, x_stride, w: y, y_stride,
                vectors: ["{w}" "{w}+32" "{w}+64"],
                factors: ["{x}" "{x}+4" "{x}+8" "{x}+12"],
                four: {
                    ("" "") ("+{t}" "+{s}") then "lea {x}, [{x}+2*{s}]" "lea {w}, [{w}+2*{t}]";
                    ("" "") ("+{t}" "+{s}") then "lea {x}, [{x}+2*{s}]" "lea {w}, [{w}+2*{t}]";
                }
                one: { ("" "") then "add {x}, {s}" "add {w}, {t}"; }
                v2 = out(ymm_reg) _,
            ),
            (6, 2) => full_tile!(
                flat(&mut sums), rows, x: x, x_stride, w: y, y_stride,
                vectors: ["{w}" "{w}+32"],
                factors: ["{x}" "{x}+4" "{x}+8" "{x}+12" "{x}+16" "{x}+20"],
                four: {
                    ("" "") ("+{t}" "+{s}") then "lea {x}, [{x}+2*{s}]" "lea {w}, [{w}+2*{t}]";
                    ("" "") ("+{t}" "+{s}") then "lea {x}, [{x}+2*{s}]" "lea {w}, [{w}+2*{t}]";
                }
                one: { ("" "") then "add {x}, {s}" "add {w}, {t}"; }
            ),
            _ => {
                for row in 0..rows {
                    for (r, sums) in sums.iter_mut().enumerate() {
                        let factor = _mm256_broadcast_ss(&*x.add(row * x_stride + r));
                        for (p, sum) in sums.iter_mut().enumerate() {
                            let values = _mm256_loadu_ps(y.add(row * y_stride + p * PANEL));
                            *sum = _mm256_fmadd_ps(factor, values, *sum);
                        }
                    }
                }
            }
        }
        for (r, sums) in sums.iter().enumerate() {
            for (p, &sum) in sums.iter().enumerate() {
                _mm256_storeu_ps(out.add((p * k + r) * PANEL), sum);
            }
        }
    }
}
