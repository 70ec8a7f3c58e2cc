//! The functions that expressions can call, by name.

use crate::numeric::{Binary, Unary};

/// What stands before a parenthesis, or what an operator stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    /// Of one number.
    Unary(Unary),
    /// Of two numbers.
    Binary(Binary),
    /// [`Binary`] functions of two or more numbers.
    Fold(Binary),
    /// A condition, and what it chooses between.
    If,
    Dot,
    Cross,
    Magnitude,
    /// The slope along an axis.
    Slope(usize),
    Gradient,
    GradientMagnitude,
    Divergence,
    Vorticity,
    /// The vorticity's component along an axis.
    VorticityAlong(usize),
    VorticityMagnitude,
}

/// Every function and what it is called.
const FUNCTIONS: [(&str, Function); 44] = [
    ("abs", Function::Unary(Unary::Absolute)),
    ("sqrt", Function::Unary(Unary::SquareRoot)),
    ("exp", Function::Unary(Unary::Exponential)),
    ("log", Function::Unary(Unary::Logarithm)),
    ("ln", Function::Unary(Unary::Logarithm)),
    ("log10", Function::Unary(Unary::Logarithm10)),
    ("log2", Function::Unary(Unary::Logarithm2)),
    ("sin", Function::Unary(Unary::Sine)),
    ("cos", Function::Unary(Unary::Cosine)),
    ("tan", Function::Unary(Unary::Tangent)),
    ("asin", Function::Unary(Unary::ArcSine)),
    ("acos", Function::Unary(Unary::ArcCosine)),
    ("atan", Function::Unary(Unary::ArcTangent)),
    ("sinh", Function::Unary(Unary::HyperbolicSine)),
    ("cosh", Function::Unary(Unary::HyperbolicCosine)),
    ("tanh", Function::Unary(Unary::HyperbolicTangent)),
    ("floor", Function::Unary(Unary::Floor)),
    ("ceil", Function::Unary(Unary::Ceiling)),
    ("atan2", Function::Binary(Binary::ArcTangent2)),
    ("pow", Function::Binary(Binary::Power)),
    ("min", Function::Fold(Binary::Minimum)),
    ("max", Function::Fold(Binary::Maximum)),
    ("if", Function::If),
    ("lt", Function::Binary(Binary::Less)),
    ("le", Function::Binary(Binary::LessOrEqual)),
    ("gt", Function::Binary(Binary::Greater)),
    ("ge", Function::Binary(Binary::GreaterOrEqual)),
    ("eq", Function::Binary(Binary::Equal)),
    ("ne", Function::Binary(Binary::NotEqual)),
    ("dot", Function::Dot),
    ("cross", Function::Cross),
    ("magnitude", Function::Magnitude),
    ("gradient", Function::Gradient),
    ("gradient_x", Function::Slope(0)),
    ("gradient_y", Function::Slope(1)),
    ("gradient_z", Function::Slope(2)),
    ("gradient_magnitude", Function::GradientMagnitude),
    ("divergence", Function::Divergence),
    ("vorticity", Function::Vorticity),
    ("curl", Function::Vorticity),
    ("vorticity_x", Function::VorticityAlong(0)),
    ("vorticity_y", Function::VorticityAlong(1)),
    ("vorticity_z", Function::VorticityAlong(2)),
    ("vorticity_magnitude", Function::VorticityMagnitude),
];

impl Function {
    /// The function that is called `name`.
    pub(crate) fn named(name: &str) -> Option<Self> {
        FUNCTIONS.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
    }

    /// The names of all functions, for messages.
    pub(crate) fn names() -> String {
        FUNCTIONS.map(|(name, _)| name).join(", ")
    }
}
