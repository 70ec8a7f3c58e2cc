//! Expressions over fields: from `sqrt(vx^2 + vy^2)` to a field with a value in each cell.
//!
//! An expression is read by [`Expression::parse`], bound to fields by [`Program::bind`], and evaluated by
//! [`Program::evaluate`]. Names, functions and derivatives are as in `docs/derived-fields.md`; the way of writing is that
//! of VisIt and of the expressions that Chombo keeps in its files.
//!
//! ```
//! use std::sync::Arc;
//!
//! use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
//! use amray_expressions::{Expression, Names, Program};
//!
//! let cells = IndexBox::new([0; 3], [4; 3]);
//! let level = LevelDescription { ratio: [1; 3], cell_size: [0.25; 3], domain: cells, bricks: vec![cells] };
//! let hierarchy = Arc::new(Hierarchy::new([0.0; 3], vec![level])?);
//! let momentum = Field::from_fn("x-momentum", &hierarchy, |_, [i, ..]| 3.0 * i as f64);
//!
//! let expression = Expression::parse("<x-momentum>^2 / 3 + x")?;
//! let program = Program::bind(&expression, &Names { fields: &["x-momentum"], definitions: &[] })?;
//! let field = program.evaluate("energy", &hierarchy, &[momentum], &|_| {})?;
//! assert_eq!(field.value(0, [2, 0, 0]), 12.0 + 0.625);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bind;
mod differences;
mod error;
mod evaluate;
mod function;
mod graph;
mod numeric;
mod parse;
mod program;
mod source;

pub use bind::{Definition, Names};
pub use error::{ExpressionError, quoted};
pub use parse::Expression;
pub use program::Program;
