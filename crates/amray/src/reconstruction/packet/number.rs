//! What packets compute with: sixteen values alone, or sixteen values with their gradients in one pass.

use std::ops::{Add, Div, Mul, Sub};

use fearless_simd::prelude::*;

use super::super::ValueAndGradient;
use super::super::number::Number;
use crate::hierarchy::LaneNormalisation;
use crate::simd::{Floats, Gather, Mask};

/// Sixteen numbers that may know how they change with their points: [`Number`] for packets. A method written over it
/// gives the values with [`Floats`], and with [`ValuesAndGradients`] the exact derivatives of the same formula beside
/// them.
pub(crate) trait LaneNumber<S: Gather>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Whether they know how they change. Then what has no weight at a point takes part if its weight begins there.
    const HAS_SLOPES: bool;

    /// What the reference computes with.
    type Scalar: Number;

    /// Numbers that do not change.
    fn constant(values: Floats<S>) -> Self;

    /// Numbers that change along `axis` alone, by `slopes` per cell.
    fn along(axis: usize, values: Floats<S>, slopes: Floats<S>) -> Self;

    /// The numbers at the points themselves.
    fn values(self) -> Floats<S>;

    /// Where all of the number is finite.
    fn all_finite(self) -> Mask<S>;

    /// Where these weights, which are not below 0, are above 0 or begin to be: what they weigh takes part.
    fn takes_part(self) -> Mask<S>;

    /// `yes` where the mask is set, else `no`.
    fn select(mask: Mask<S>, yes: Self, no: Self) -> Self;

    /// `sum` and `numbers` times these weights. Where a number has slopes, and the value or a derivative of its weight is
    /// zero, it does not take part in that one, not even a number that is not finite.
    fn weigh(self, numbers: Self, sum: Self) -> Self;

    /// [`weigh`](Self::weigh) for numbers that do not change.
    fn weigh_values(self, values: Floats<S>, sum: Self) -> Self;

    /// From `low` where the share is 0 to `high` where it is 1.
    fn mix(low: Self, high: Self, share: Self) -> Self;

    /// The trilinear weights of a corner (x + 2 y + 4 z, 0 low and 1 high per axis); the weights of an axis change
    /// [along](Self::along) that one alone.
    fn hat(weights: &[[Self; 2]; 3], corner: usize) -> Self;

    /// Trilinear interpolation between eight corners, x fastest; `share` is that of the high side and changes
    /// [along](Self::along) its axis alone.
    fn trilinear(corners: &[Floats<S>; 8], share: [Self; 3]) -> Self;

    /// The same numbers, where cells are `cells` times as long: slopes are per cell.
    fn per_cells(self, cells: &[f64; 3]) -> Self;

    /// Puts what the reference has found, which is not normalised yet, into a lane.
    fn set_lane(&mut self, lane: usize, number: Self::Scalar, normalisation: &LaneNormalisation);
}

/// The weights of the low and of the high end of a unit interval that lies along `axis`, where the high end's grow by
/// `slope` per cell.
#[inline(always)]
pub(crate) fn linear_weights<S: Gather, N: LaneNumber<S>>(
    axis: usize,
    [low, high]: [Floats<S>; 2],
    slope: Floats<S>,
) -> [N; 2] {
    [N::along(axis, low, -slope), N::along(axis, high, slope)]
}

/// A sum of hats that is exactly 1 where it is all of them, `whole`, whatever rounding made of it.
#[inline(always)]
pub(crate) fn made_whole<S: Gather, N: LaneNumber<S>>(simd: S, whole: Mask<S>, weight: N) -> N {
    let rest = Floats::splat(simd, 1.0) - weight.values();
    N::select(whole, weight + N::constant(rest), weight)
}

/// Sixteen values and their gradients: dual numbers, whose arithmetic carries derivatives along (forward-mode
/// differentiation). Where a value is not finite, its gradient means nothing.
#[derive(Clone, Copy)]
pub(crate) struct ValuesAndGradients<S: Gather> {
    pub(crate) values: Floats<S>,
    /// Along each axis, per cell.
    pub(crate) gradients: [Floats<S>; 3],
}

impl<S: Gather> LaneNumber<S> for Floats<S> {
    const HAS_SLOPES: bool = false;

    type Scalar = f64;

    #[inline(always)]
    fn constant(values: Floats<S>) -> Self {
        values
    }

    #[inline(always)]
    fn along(_axis: usize, values: Floats<S>, _slopes: Floats<S>) -> Self {
        values
    }

    #[inline(always)]
    fn values(self) -> Floats<S> {
        self
    }

    #[inline(always)]
    fn all_finite(self) -> Mask<S> {
        self.is_finite()
    }

    #[inline(always)]
    fn takes_part(self) -> Mask<S> {
        self.simd_gt(0.0)
    }

    #[inline(always)]
    fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        mask.select(yes, no)
    }

    #[inline(always)]
    fn weigh(self, numbers: Self, sum: Self) -> Self {
        self.mul_add(numbers, sum)
    }

    #[inline(always)]
    fn weigh_values(self, values: Floats<S>, sum: Self) -> Self {
        self.mul_add(values, sum)
    }

    #[inline(always)]
    fn mix(low: Self, high: Self, share: Self) -> Self {
        (high - low).mul_add(share, low)
    }

    #[inline(always)]
    fn hat([x, y, z]: &[[Self; 2]; 3], corner: usize) -> Self {
        y[corner >> 1 & 1] * z[corner >> 2] * x[corner & 1]
    }

    #[inline(always)]
    fn trilinear(&[a, b, c, d, e, f, g, h]: &[Floats<S>; 8], [x, y, z]: [Self; 3]) -> Self {
        let low = Self::mix(Self::mix(a, b, x), Self::mix(c, d, x), y);
        let high = Self::mix(Self::mix(e, f, x), Self::mix(g, h, x), y);
        Self::mix(low, high, z)
    }

    #[inline(always)]
    fn per_cells(self, _cells: &[f64; 3]) -> Self {
        self
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, number: f64, normalisation: &LaneNormalisation) {
        self[lane] = normalisation.of_value(number);
    }
}

/// A weight times a number that takes part where the weight is not zero, and `sum`.
#[inline(always)]
fn weigh_part<S: Gather>(weights: Floats<S>, numbers: Floats<S>, sum: Floats<S>) -> Floats<S> {
    weights.simd_ne(0.0).select(weights.mul_add(numbers, sum), sum)
}

impl<S: Gather> LaneNumber<S> for ValuesAndGradients<S> {
    const HAS_SLOPES: bool = true;

    type Scalar = ValueAndGradient;

    #[inline(always)]
    fn constant(values: Floats<S>) -> Self {
        Self { values, gradients: [Floats::splat(values.simd, 0.0); 3] }
    }

    #[inline(always)]
    fn along(axis: usize, values: Floats<S>, slopes: Floats<S>) -> Self {
        let mut number = Self::constant(values);
        number.gradients[axis] = slopes;
        number
    }

    #[inline(always)]
    fn values(self) -> Floats<S> {
        self.values
    }

    #[inline(always)]
    fn all_finite(self) -> Mask<S> {
        let [x, y, z] = self.gradients;
        self.values.is_finite() & x.is_finite() & y.is_finite() & z.is_finite()
    }

    #[inline(always)]
    fn takes_part(self) -> Mask<S> {
        let [x, y, z] = self.gradients;
        self.values.simd_gt(0.0) | x.simd_ne(0.0) | y.simd_ne(0.0) | z.simd_ne(0.0)
    }

    #[inline(always)]
    fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        let mut selected = Self { values: mask.select(yes.values, no.values), gradients: no.gradients };
        for axis in 0..3 {
            selected.gradients[axis] = mask.select(yes.gradients[axis], no.gradients[axis]);
        }
        selected
    }

    #[inline(always)]
    fn weigh(self, numbers: Self, sum: Self) -> Self {
        let mut weighed = self.weigh_values(numbers.values, sum);
        for axis in 0..3 {
            weighed.gradients[axis] = weigh_part(self.values, numbers.gradients[axis], weighed.gradients[axis]);
        }
        weighed
    }

    #[inline(always)]
    fn weigh_values(self, values: Floats<S>, sum: Self) -> Self {
        let mut weighed = sum;
        weighed.values = weigh_part(self.values, values, sum.values);
        for axis in 0..3 {
            weighed.gradients[axis] = weigh_part(self.gradients[axis], values, sum.gradients[axis]);
        }
        weighed
    }

    #[inline(always)]
    fn mix(low: Self, high: Self, share: Self) -> Self {
        let one = Self::constant(Floats::splat(share.values.simd, 1.0));
        let nothing = Self::constant(Floats::splat(share.values.simd, 0.0));
        share.weigh(high, (one - share).weigh(low, nothing))
    }

    #[inline(always)]
    fn hat([x, y, z]: &[[Self; 2]; 3], corner: usize) -> Self {
        let (x, y, z) = (x[corner & 1], y[corner >> 1 & 1], z[corner >> 2]);
        let yz = y.values * z.values;
        Self {
            values: yz * x.values,
            gradients: [
                yz * x.gradients[0],
                x.values * z.values * y.gradients[1],
                x.values * y.values * z.gradients[2],
            ],
        }
    }

    #[inline(always)]
    fn trilinear(corners: &[Floats<S>; 8], [x, y, z]: [Self; 3]) -> Self {
        // The slopes are the differences that interpolation takes anyway, interpolated along the other axes.
        let mut rise_x = [corners[0]; 4];
        let mut edges = [corners[0]; 4];
        for edge in 0..4 {
            let (low, high) = (corners[2 * edge], corners[2 * edge + 1]);
            rise_x[edge] = high - low;
            edges[edge] = rise_x[edge].mul_add(x.values, low);
        }
        let mut rise_y = [corners[0]; 2];
        let mut faces = [corners[0]; 2];
        for face in 0..2 {
            let (low, high) = (edges[2 * face], edges[2 * face + 1]);
            rise_y[face] = high - low;
            faces[face] = rise_y[face].mul_add(y.values, low);
            rise_x[face] = Floats::mix(rise_x[2 * face], rise_x[2 * face + 1], y.values);
        }
        let rise_z = faces[1] - faces[0];
        Self {
            values: rise_z.mul_add(z.values, faces[0]),
            gradients: [
                Floats::mix(rise_x[0], rise_x[1], z.values) * x.gradients[0],
                Floats::mix(rise_y[0], rise_y[1], z.values) * y.gradients[1],
                rise_z * z.gradients[2],
            ],
        }
    }

    #[inline(always)]
    fn per_cells(mut self, cells: &[f64; 3]) -> Self {
        for axis in 0..3 {
            self.gradients[axis] *= cells[axis] as f32;
        }
        self
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, number: ValueAndGradient, normalisation: &LaneNormalisation) {
        self.values[lane] = normalisation.of_value(number.value);
        for axis in 0..3 {
            self.gradients[axis][lane] = normalisation.of_slope(number.gradient[axis]);
        }
    }
}

impl<S: Gather> Add for ValuesAndGradients<S> {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.values += other.values;
        for axis in 0..3 {
            self.gradients[axis] += other.gradients[axis];
        }
        self
    }
}

impl<S: Gather> Sub for ValuesAndGradients<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.values -= other.values;
        for axis in 0..3 {
            self.gradients[axis] -= other.gradients[axis];
        }
        self
    }
}

impl<S: Gather> Mul for ValuesAndGradients<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let mut product = Self { values: self.values * other.values, gradients: self.gradients };
        for axis in 0..3 {
            let by_other = self.values * other.gradients[axis];
            product.gradients[axis] = self.gradients[axis].mul_add(other.values, by_other);
        }
        product
    }
}

impl<S: Gather> Div for ValuesAndGradients<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let mut quotient = Self { values: self.values / other.values, gradients: self.gradients };
        let share = Floats::splat(self.values.simd, 1.0) / other.values;
        for axis in 0..3 {
            let rise = (-quotient.values).mul_add(other.gradients[axis], self.gradients[axis]);
            quotient.gradients[axis] = rise * share;
        }
        quotient
    }
}
