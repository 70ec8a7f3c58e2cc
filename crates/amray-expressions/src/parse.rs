//! From text to a tree: precedence climbing, with a bound on how deep things nest.

use crate::error::ExpressionError;
use crate::function::Function;
use crate::numeric::{Binary, Unary};

/// The longest expression, in bytes.
const LONGEST: usize = 4096;

/// How deep parentheses, calls, signs and powers may nest.
const DEEPEST: usize = 100;

/// An expression that was read; its names are not looked up yet.
#[derive(Clone, Debug)]
pub struct Expression {
    nodes: Vec<Node>,
}

/// A part of an expression, after all parts that it is made of.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Where it is written, in characters from 1 on.
    pub(crate) column: usize,
    pub(crate) kind: NodeKind,
}

/// What a part of an expression is; other parts go by their places.
#[derive(Clone, Debug)]
pub(crate) enum NodeKind {
    Number(f64),
    Name(String),
    /// A call or an operator, with its name as it is written.
    Call(Function, String, Vec<usize>),
    /// `{a, b, c}`.
    Vector([usize; 3]),
    /// `v[0]`, `v[1]` or `v[2]`.
    Component(usize, usize),
}

impl Expression {
    /// Reads an expression. It has at most 4096 bytes and nests at most 100 deep.
    ///
    /// # Errors
    /// [`ExpressionError::Invalid`] says in which column what was expected.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        if text.len() > LONGEST {
            return Err(ExpressionError::invalid(1, format!("{} bytes, expected at most {LONGEST}", text.len())));
        }
        let mut parser = Parser { text, at: 0, column: 1, depth: 0, nodes: Vec::new() };
        parser.expression(0)?;
        match parser.next() {
            None => Ok(Self { nodes: parser.nodes }),
            Some(_) => Err(parser.expected("an operator or the end")),
        }
    }

    /// The expression that is one name, whatever characters are in it.
    pub fn name(name: &str) -> Self {
        Self { nodes: vec![Node { column: 1, kind: NodeKind::Name(name.into()) }] }
    }

    /// The parts; each follows those that it is made of, the last one is the whole.
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }
}

/// How tight an operator binds; unary minus lies between products and powers.
const SIGN: u8 = 4;

/// Operators, how tight they bind, and how tight what is on their right must at least.
const OPERATORS: [(&str, Binary, u8, u8); 12] = [
    // The longer ones first, so that they are not taken for the shorter.
    ("<=", Binary::LessOrEqual, 1, 2),
    (">=", Binary::GreaterOrEqual, 1, 2),
    ("==", Binary::Equal, 1, 2),
    ("!=", Binary::NotEqual, 1, 2),
    ("<", Binary::Less, 1, 2),
    (">", Binary::Greater, 1, 2),
    ("+", Binary::Add, 2, 3),
    ("-", Binary::Subtract, 2, 3),
    ("**", Binary::Power, 5, SIGN),
    ("*", Binary::Multiply, 3, SIGN),
    ("/", Binary::Divide, 3, SIGN),
    ("^", Binary::Power, 5, SIGN),
];

struct Parser<'a> {
    text: &'a str,
    /// Where the rest begins, in bytes.
    at: usize,
    /// The same in characters, from 1 on.
    column: usize,
    depth: usize,
    nodes: Vec<Node>,
}

impl Parser<'_> {
    /// Operands and the operators between them that bind at least as tight as `loosest`.
    fn expression(&mut self, loosest: u8) -> Result<usize, ExpressionError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            let problem = format!("parts nest deeper than {DEEPEST}");
            return Err(ExpressionError::invalid(self.column, problem));
        }
        let mut left = self.operand()?;
        while let Some((operator, function, tightness, right)) = self.operator()
            && tightness >= loosest
        {
            let column = self.column;
            self.advance(operator.len());
            let right = self.expression(right)?;
            left = self.call(column, Function::Binary(function), operator, vec![left, right]);
        }
        self.depth -= 1;
        Ok(left)
    }

    fn operator(&mut self) -> Option<(&'static str, Binary, u8, u8)> {
        self.skip_blanks();
        OPERATORS.into_iter().find(|(operator, ..)| self.rest().starts_with(operator))
    }

    /// A number, a name, a call, what is in parentheses; perhaps with signs before and components behind.
    fn operand(&mut self) -> Result<usize, ExpressionError> {
        let next = self.next();
        let column = self.column;
        let mut operand = match next {
            Some('-') => {
                self.advance(1);
                let operand = self.expression(SIGN)?;
                return Ok(self.call(column, Function::Unary(Unary::Negate), "-", vec![operand]));
            }
            Some('+') => {
                self.advance(1);
                return self.expression(SIGN);
            }
            Some('(') => {
                self.advance(1);
                let inner = self.expression(0)?;
                self.expect(')')?;
                inner
            }
            Some('{') => {
                self.advance(1);
                let parts = self.list('}')?;
                let count = parts.len();
                let parts = parts.try_into().map_err(|_| {
                    ExpressionError::invalid(column, format!("a vector of {count} components, expected 3"))
                })?;
                self.push(column, NodeKind::Vector(parts))
            }
            Some('<') => {
                let Some(length) = self.rest().find('>') else {
                    return Err(ExpressionError::invalid(
                        column,
                        "a name that starts with < and has no end, expected >",
                    ));
                };
                let name = self.rest()[1..length].to_owned();
                self.advance(length + 1);
                self.push(column, NodeKind::Name(name))
            }
            Some(digit) if digit.is_ascii_digit() || digit == '.' => self.number()?,
            Some(letter) if letter.is_alphabetic() || letter == '_' => self.name_or_call()?,
            _ => return Err(self.expected("a number, a name or a parenthesis")),
        };
        while self.next() == Some('[') {
            operand = self.component(operand)?;
        }
        Ok(operand)
    }

    fn number(&mut self) -> Result<usize, ExpressionError> {
        let column = self.column;
        let bytes = self.rest().as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let mut length = digits(0);
        if bytes.get(length) == Some(&b'.') {
            length += 1;
            length += digits(length);
        }
        if let Some(b'e' | b'E') = bytes.get(length) {
            let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
            let exponent = digits((length + 1 + sign).min(bytes.len()));
            // `2e` is the number 2 before a name.
            length += if exponent > 0 { 1 + sign + exponent } else { 0 };
        }
        let number = self.rest()[..length].parse().map_err(|_| self.expected("a number"))?;
        self.advance(length);
        Ok(self.push(column, NodeKind::Number(number)))
    }

    fn name_or_call(&mut self) -> Result<usize, ExpressionError> {
        let column = self.column;
        let rest = self.rest();
        let length = rest.find(|letter: char| !letter.is_alphanumeric() && letter != '_').unwrap_or(rest.len());
        let name = rest[..length].to_owned();
        self.advance(length);
        if self.next() != Some('(') {
            return Ok(self.push(column, NodeKind::Name(name)));
        }
        let Some(function) = Function::named(&name) else {
            let problem = format!("no function {name:?}; the functions are {}", Function::names());
            return Err(ExpressionError::invalid(column, problem));
        };
        self.advance(1);
        let arguments = self.list(')')?;
        Ok(self.call(column, function, &name, arguments))
    }

    /// Expressions between commas, up to `end`.
    fn list(&mut self, end: char) -> Result<Vec<usize>, ExpressionError> {
        let mut parts = Vec::new();
        if self.next() != Some(end) {
            parts.push(self.expression(0)?);
            while self.next() == Some(',') {
                self.advance(1);
                parts.push(self.expression(0)?);
            }
        }
        self.expect(end)?;
        Ok(parts)
    }

    /// `[0]`, `[1]` or `[2]` behind a vector.
    fn component(&mut self, vector: usize) -> Result<usize, ExpressionError> {
        let column = self.column;
        self.advance(1);
        let component = match self.next() {
            Some('0') => 0,
            Some('1') => 1,
            Some('2') => 2,
            _ => return Err(self.expected("0, 1 or 2")),
        };
        self.advance(1);
        self.expect(']')?;
        Ok(self.push(column, NodeKind::Component(vector, component)))
    }

    fn call(&mut self, column: usize, function: Function, name: &str, arguments: Vec<usize>) -> usize {
        self.push(column, NodeKind::Call(function, name.to_owned(), arguments))
    }

    fn push(&mut self, column: usize, kind: NodeKind) -> usize {
        self.nodes.push(Node { column, kind });
        self.nodes.len() - 1
    }

    fn expect(&mut self, expected: char) -> Result<(), ExpressionError> {
        if self.next() != Some(expected) {
            return Err(self.expected(&format!("{expected:?}")));
        }
        self.advance(expected.len_utf8());
        Ok(())
    }

    fn expected(&self, what: &str) -> ExpressionError {
        let problem = match self.rest().chars().next() {
            Some(found) => format!("found {found:?}, expected {what}"),
            None => format!("expected {what}"),
        };
        ExpressionError::invalid(self.column, problem)
    }

    /// The next character that is no blank.
    fn next(&mut self) -> Option<char> {
        self.skip_blanks();
        self.rest().chars().next()
    }

    fn skip_blanks(&mut self) {
        self.advance(self.rest().len() - self.rest().trim_start().len());
    }

    fn advance(&mut self, bytes: usize) {
        self.column += self.rest()[..bytes].chars().count();
        self.at += bytes;
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }
}
