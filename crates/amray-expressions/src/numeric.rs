//! Arithmetic over slices of cells, in double precision. What is undefined is not a number.

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Unary {
    Negate,
    Absolute,
    SquareRoot,
    Exponential,
    Logarithm,
    Logarithm10,
    Logarithm2,
    Sine,
    Cosine,
    Tangent,
    ArcSine,
    ArcCosine,
    ArcTangent,
    HyperbolicSine,
    HyperbolicCosine,
    HyperbolicTangent,
    Floor,
    Ceiling,
}

/// A function of two numbers. Comparisons are 1 where they hold and else 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Minimum,
    Maximum,
    ArcTangent2,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
}

impl Unary {
    /// The function of one number.
    pub(crate) fn of(self, value: f64) -> f64 {
        let mut result = [0.0];
        self.apply(&mut result, &[value]);
        result[0]
    }

    /// The function of each of `values`.
    pub(crate) fn apply(self, results: &mut [f64], values: &[f64]) {
        match self {
            Self::Negate => each(results, values, |value| -value),
            Self::Absolute => each(results, values, f64::abs),
            Self::SquareRoot => each(results, values, f64::sqrt),
            Self::Exponential => each(results, values, f64::exp),
            Self::Logarithm => each(results, values, f64::ln),
            Self::Logarithm10 => each(results, values, f64::log10),
            Self::Logarithm2 => each(results, values, f64::log2),
            Self::Sine => each(results, values, f64::sin),
            Self::Cosine => each(results, values, f64::cos),
            Self::Tangent => each(results, values, f64::tan),
            Self::ArcSine => each(results, values, f64::asin),
            Self::ArcCosine => each(results, values, f64::acos),
            Self::ArcTangent => each(results, values, f64::atan),
            Self::HyperbolicSine => each(results, values, f64::sinh),
            Self::HyperbolicCosine => each(results, values, f64::cosh),
            Self::HyperbolicTangent => each(results, values, f64::tanh),
            Self::Floor => each(results, values, f64::floor),
            Self::Ceiling => each(results, values, f64::ceil),
        }
    }
}

impl Binary {
    /// The function of two numbers.
    pub(crate) fn of(self, left: f64, right: f64) -> f64 {
        let mut result = [0.0];
        self.apply(&mut result, &[left], &[right]);
        result[0]
    }

    /// The function of each pair.
    pub(crate) fn apply(self, results: &mut [f64], left: &[f64], right: &[f64]) {
        match self {
            Self::Add => pairs(results, left, right, |a, b| a + b),
            Self::Subtract => pairs(results, left, right, |a, b| a - b),
            Self::Multiply => pairs(results, left, right, |a, b| a * b),
            Self::Divide => pairs(results, left, right, |a, b| a / b),
            Self::Power => pairs(results, left, right, f64::powf),
            // Unlike those of the standard library, these do not hide what is not a number.
            Self::Minimum => pairs(results, left, right, |a, b| if a < b || a.is_nan() { a } else { b }),
            Self::Maximum => pairs(results, left, right, |a, b| if a > b || a.is_nan() { a } else { b }),
            Self::ArcTangent2 => pairs(results, left, right, f64::atan2),
            Self::Less => compare(results, left, right, |a, b| a < b),
            Self::LessOrEqual => compare(results, left, right, |a, b| a <= b),
            Self::Greater => compare(results, left, right, |a, b| a > b),
            Self::GreaterOrEqual => compare(results, left, right, |a, b| a >= b),
            Self::Equal => compare(results, left, right, |a, b| a == b),
            Self::NotEqual => compare(results, left, right, |a, b| a != b),
        }
    }
}

/// One number where a condition is not 0, else another; not a number where the condition is none.
pub(crate) fn choose(condition: f64, then: f64, otherwise: f64) -> f64 {
    if condition.is_nan() {
        f64::NAN
    } else if condition != 0.0 {
        then
    } else {
        otherwise
    }
}

fn each(results: &mut [f64], values: &[f64], function: impl Fn(f64) -> f64) {
    for (result, value) in results.iter_mut().zip(values) {
        *result = function(*value);
    }
}

fn pairs(results: &mut [f64], left: &[f64], right: &[f64], function: impl Fn(f64, f64) -> f64) {
    for ((result, left), right) in results.iter_mut().zip(left).zip(right) {
        *result = function(*left, *right);
    }
}

fn compare(results: &mut [f64], left: &[f64], right: &[f64], holds: impl Fn(f64, f64) -> bool) {
    pairs(results, left, right, |a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { f64::from(holds(a, b)) });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_undefined_is_not_a_number() {
        for function in [Unary::SquareRoot, Unary::Logarithm, Unary::Logarithm10, Unary::Logarithm2] {
            assert!(function.of(-1.0).is_nan(), "{function:?}");
        }
        for function in [Binary::Minimum, Binary::Maximum, Binary::Less, Binary::Equal, Binary::NotEqual] {
            assert!(function.of(f64::NAN, 1.0).is_nan() && function.of(1.0, f64::NAN).is_nan(), "{function:?}");
        }
        assert!(choose(f64::NAN, 1.0, 2.0).is_nan());
        assert_eq!([choose(-3.0, 1.0, 2.0), choose(0.0, 1.0, f64::NAN)].map(f64::is_nan), [false, true]);
    }

    #[test]
    fn comparisons_are_1_or_0() {
        let found = [Binary::Less, Binary::LessOrEqual, Binary::Greater, Binary::GreaterOrEqual, Binary::Equal]
            .map(|function| [function.of(1.0, 2.0), function.of(2.0, 2.0), function.of(3.0, 2.0)]);
        assert_eq!(found, [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0]]);
        assert_eq!([Binary::Minimum, Binary::Maximum].map(|function| function.of(-1.0, 2.0)), [-1.0, 2.0]);
    }
}
