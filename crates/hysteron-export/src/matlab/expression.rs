//! From tokens to the tree: expressions, by their precedence in C.

use super::Untranslated;
use super::parse::Parser;
use super::syntax::Expression;
use super::tokens::Token;

/// Operators of two operands, the loosest first.
const LEVELS: [&[&str]; 7] =
    [&["||"], &["&&"], &["&"], &["==", "!="], &["<", ">", "<=", ">="], &["+", "-"], &["*", "/", "%"]];

impl Parser<'_> {
    /// An expression without commas.
    pub fn expression(&mut self) -> Result<Expression, Untranslated> {
        let left = self.chosen()?;
        for operator in ["=", "+=", "-="] {
            if self.takes(operator) {
                let right = self.expression()?;
                return Ok(Expression::Assign(Box::new(left), operator, Box::new(right)));
            }
        }
        Ok(left)
    }

    fn chosen(&mut self) -> Result<Expression, Untranslated> {
        let condition = self.binary(0)?;
        if !self.takes("?") {
            return Ok(condition);
        }
        let then = self.expression()?;
        self.expect(":")?;
        let other = self.chosen()?;
        Ok(Expression::Choice(Box::new(condition), Box::new(then), Box::new(other)))
    }

    fn binary(&mut self, level: usize) -> Result<Expression, Untranslated> {
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let mut left = self.binary(level + 1)?;
        while let Some(operator) = operators.iter().find(|operator| self.comes(0, operator)) {
            self.next();
            let right = self.binary(level + 1)?;
            left = Expression::Binary(operator, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    fn unary(&mut self) -> Result<Expression, Untranslated> {
        for operator in ["-", "!"] {
            if self.takes(operator) {
                return Ok(Expression::Unary(operator, Box::new(self.unary()?)));
            }
        }
        if self.takes("*") {
            return Ok(Expression::At(Box::new(self.unary()?)));
        }
        if self.takes("&") {
            return Ok(Expression::AddressOf(Box::new(self.unary()?)));
        }
        if self.takes("++") {
            return Ok(Expression::Step(Box::new(self.unary()?), 1, false));
        }
        if self.comes(0, "(") && self.is_type(1) {
            self.next();
            let (of, _) = self.type_name()?;
            let pointer = self.takes("*");
            self.expect(")")?;
            return Ok(Expression::Cast(of, pointer, Box::new(self.unary()?)));
        }
        self.postfix()
    }

    fn postfix(&mut self) -> Result<Expression, Untranslated> {
        let mut value = match self.next() {
            Some(Token::Number(text, whole)) => Expression::Number(text.clone(), *whole),
            Some(Token::Name(name)) => match name.as_str() {
                "true" => Expression::Number("1".into(), true),
                "false" => Expression::Number("0".into(), true),
                _ => Expression::Name(name.clone()),
            },
            Some(Token::Mark("(")) => {
                let inside = self.expression()?;
                self.expect(")")?;
                inside
            }
            _ => return Err(self.unexpected("an expression")),
        };
        loop {
            if self.takes("[") {
                let index = self.expression()?;
                self.expect("]")?;
                value = Expression::Index(Box::new(value), Box::new(index));
            } else if self.takes(".") || self.takes("->") {
                let Some(Token::Name(member)) = self.next() else {
                    return Err(self.unexpected("a member"));
                };
                value = Expression::Member(Box::new(value), member.clone());
            } else if self.takes("(") {
                let mut arguments = Vec::new();
                while !self.takes(")") {
                    arguments.push(self.expression()?);
                    self.takes(",");
                }
                value = Expression::Call(Box::new(value), arguments);
            } else if self.takes("++") {
                value = Expression::Step(Box::new(value), 1, true);
            } else if self.takes("--") {
                value = Expression::Step(Box::new(value), -1, true);
            } else {
                return Ok(value);
            }
        }
    }
}
