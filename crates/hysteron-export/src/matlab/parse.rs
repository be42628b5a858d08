//! From tokens to the tree: declarations and statements.

use super::Untranslated;
use super::syntax::{Constants, Expression, Function, Initial, Named, Signature, Source, Statement, Type};
use super::tokens::Token;

/// A place in the tokens, and what has been declared before it.
pub(super) struct Parser<'a> {
    tokens: &'a [Token],
    at: usize,
    pub source: Source,
}

impl<'a> Parser<'a> {
    pub fn new(tokens: &'a [Token]) -> Self {
        Self { tokens, at: 0, source: Source::default() }
    }

    /// The whole source.
    pub fn source(mut self) -> Result<Source, Untranslated> {
        loop {
            let comment = self.comment();
            if self.at >= self.tokens.len() {
                return Ok(self.source);
            }
            self.external(comment)?;
        }
    }

    /// The next token that is no comment, `ahead` of those behind it.
    pub fn peek(&self, ahead: usize) -> Option<&'a Token> {
        self.tokens[self.at..].iter().filter(|t| !matches!(t, Token::Comment(_))).nth(ahead)
    }

    pub fn next(&mut self) -> Option<&'a Token> {
        while let Some(token) = self.tokens.get(self.at) {
            self.at += 1;
            if !matches!(token, Token::Comment(_)) {
                return Some(token);
            }
        }
        None
    }

    /// Takes a mark or a word where it comes next.
    pub fn takes(&mut self, text: &str) -> bool {
        let is_it = self.comes(0, text);
        if is_it {
            self.next();
        }
        is_it
    }

    pub fn comes(&self, ahead: usize, text: &str) -> bool {
        match self.peek(ahead) {
            Some(Token::Mark(mark)) => *mark == text,
            Some(Token::Name(name)) => name == text,
            _ => false,
        }
    }

    pub fn expect(&mut self, text: &'static str) -> Result<(), Untranslated> {
        if self.takes(text) { Ok(()) } else { Err(self.unexpected(text)) }
    }

    pub fn unexpected(&self, wanted: &'static str) -> Untranslated {
        let rest: Vec<String> = self.tokens[self.at..].iter().take(8).map(|t| format!("{t:?}")).collect();
        Untranslated::new(wanted, &rest.join(" "))
    }

    fn name(&mut self) -> Result<String, Untranslated> {
        match self.next() {
            Some(Token::Name(name)) => Ok(name.clone()),
            _ => Err(self.unexpected("a name")),
        }
    }

    /// The comments that come next, the last of them alone.
    fn comment(&mut self) -> Option<String> {
        let mut last = None;
        while let Some(Token::Comment(text)) = self.tokens.get(self.at) {
            last = Some(text.clone());
            self.at += 1;
        }
        last
    }

    /// Whether a type comes next.
    pub fn is_type(&self, ahead: usize) -> bool {
        let Some(Token::Name(name)) = self.peek(ahead) else { return false };
        matches!(
            name.as_str(),
            "const" | "static" | "struct" | "void" | "bool" | "int32_t" | "uint32_t" | "double" | "float"
        ) || self.source.types.contains_key(name)
    }

    /// A type; whether it is constant.
    pub fn type_name(&mut self) -> Result<(Type, bool), Untranslated> {
        let mut constant = false;
        while self.comes(0, "const") || self.comes(0, "static") {
            constant |= self.comes(0, "const");
            self.next();
        }
        if self.takes("struct") {
            return Ok((Type::Struct(self.name()?), constant));
        }
        let name = self.name()?;
        let of = match name.as_str() {
            "void" => Type::Void,
            "bool" | "int32_t" | "uint32_t" => Type::Int,
            "double" | "float" => Type::Real,
            _ => self.source.types.get(&name).cloned().ok_or_else(|| Untranslated::new("a type", &name))?,
        };
        Ok((of, constant))
    }

    /// `*name[size][size]` of a type.
    fn declarator(&mut self, of: &Type, constant: bool) -> Result<Named, Untranslated> {
        let mut pointer = self.takes("*");
        let name = self.name()?;
        let mut sizes = Vec::new();
        while self.takes("[") {
            if self.takes("]") {
                pointer = true;
            } else {
                let size = self.expression()?;
                self.expect("]")?;
                sizes.push(whole(&size).ok_or_else(|| Untranslated::new("a size", &format!("{size:?}")))?);
            }
        }
        Ok(Named { name, of: of.clone(), constant, pointer, sizes })
    }

    fn parameters(&mut self) -> Result<Vec<Named>, Untranslated> {
        self.expect("(")?;
        let mut parameters = Vec::new();
        while !self.takes(")") {
            let (of, constant) = self.type_name()?;
            parameters.push(self.declarator(&of, constant)?);
            self.takes(",");
        }
        Ok(parameters)
    }

    /// A declaration outside of functions.
    fn external(&mut self, comment: Option<String>) -> Result<(), Untranslated> {
        if self.takes("typedef") {
            return self.new_type();
        }
        let (of, constant) = self.type_name()?;
        if self.comes(1, "(") {
            let name = self.name()?;
            let signature = Signature { returns: of, parameters: self.parameters()? };
            if self.takes(";") {
                return Ok(());
            }
            let body = self.block()?;
            self.source.functions.push(Function { name, comment, signature, body });
            return Ok(());
        }
        let variable = self.declarator(&of, constant)?;
        self.expect("=")?;
        let values = self.initial()?;
        self.expect(";")?;
        self.source.constants.push(Constants { comment, variable, values });
        Ok(())
    }

    fn new_type(&mut self) -> Result<(), Untranslated> {
        if self.takes("enum") {
            self.expect("{")?;
            let mut value = 0;
            while !self.takes("}") {
                let name = self.name()?;
                if self.takes("=") {
                    let given = self.expression()?;
                    value = integer(&given)
                        .ok_or_else(|| Untranslated::new("a number", &format!("{given:?}")))?;
                }
                self.source.enumerated.insert(name, value);
                value += 1;
                self.takes(",");
            }
            let name = self.name()?;
            self.source.types.insert(name, Type::Int);
        } else if self.comes(0, "struct") && (self.comes(1, "{") || self.comes(2, "{")) {
            self.next();
            let tag = if self.comes(0, "{") { None } else { Some(self.name()?) };
            self.expect("{")?;
            let mut members = Vec::new();
            while !self.takes("}") {
                self.members(&mut members)?;
            }
            let name = self.name()?;
            if tag.as_ref().is_some_and(|tag| *tag != name) {
                return Err(Untranslated::new("a structure of one name", &name));
            }
            self.source.structures.insert(name.clone(), members);
            self.source.types.insert(name.clone(), Type::Struct(name));
        } else {
            let (of, _) = self.type_name()?;
            let name = self.name()?;
            self.source.types.insert(name, of);
        }
        self.expect(";")
    }

    fn members(&mut self, members: &mut Vec<Named>) -> Result<(), Untranslated> {
        let (of, constant) = self.type_name()?;
        if self.takes("(") {
            self.expect("*")?;
            let name = self.name()?;
            self.expect(")")?;
            let signature = Signature { returns: of, parameters: self.parameters()? };
            self.source.function_members.insert(name, signature);
            return self.expect(";");
        }
        loop {
            members.push(self.declarator(&of, constant)?);
            if !self.takes(",") {
                return self.expect(";");
            }
        }
    }

    fn initial(&mut self) -> Result<Initial, Untranslated> {
        if !self.takes("{") {
            return Ok(Initial::Value(self.expression()?));
        }
        let mut values = Vec::new();
        while !self.takes("}") {
            values.push(self.initial()?);
            self.takes(",");
        }
        Ok(Initial::List(values))
    }

    /// Statements in braces.
    fn block(&mut self) -> Result<Vec<Statement>, Untranslated> {
        self.expect("{")?;
        let mut statements = Vec::new();
        loop {
            self.statement_into(&mut statements)?;
            if self.takes("}") {
                return Ok(statements);
            }
            if self.comes(0, "case") || self.comes(0, "default") || self.peek(0).is_none() {
                return Err(self.unexpected("a statement"));
            }
        }
    }

    /// Comments, and the statement behind them where the block does not end there.
    fn statement_into(&mut self, out: &mut Vec<Statement>) -> Result<(), Untranslated> {
        while let Some(Token::Comment(text)) = self.tokens.get(self.at) {
            out.push(Statement::Comment(text.clone()));
            self.at += 1;
        }
        if self.comes(0, "}") || self.comes(0, "case") || self.comes(0, "default") {
            return Ok(());
        }
        if self.comes(0, "{") {
            out.push(Statement::Block(self.block()?));
        } else if self.is_type(0) {
            self.variables(out)?;
        } else if self.takes("if") {
            out.push(self.choice()?);
        } else if self.takes("while") {
            self.expect("(")?;
            let condition = self.expression()?;
            self.expect(")")?;
            out.push(Statement::While(condition, self.block()?));
        } else if self.takes("for") {
            self.expect("(")?;
            let first = self.expression()?;
            self.expect(";")?;
            let condition = self.expression()?;
            self.expect(";")?;
            let next = self.expression()?;
            self.expect(")")?;
            out.push(Statement::For(first, condition, next, self.block()?));
        } else if self.takes("switch") {
            out.push(self.switch()?);
        } else if self.takes("return") {
            let value = if self.comes(0, ";") { None } else { Some(self.expression()?) };
            self.expect(";")?;
            out.push(Statement::Return(value));
        } else if self.takes("break") {
            self.expect(";")?;
            out.push(Statement::Break);
        } else {
            let value = self.expression()?;
            self.expect(";")?;
            out.push(Statement::Do(value));
        }
        Ok(())
    }

    fn variables(&mut self, out: &mut Vec<Statement>) -> Result<(), Untranslated> {
        let (of, constant) = self.type_name()?;
        loop {
            let variable = self.declarator(&of, constant)?;
            let initial = if self.takes("=") { Some(self.initial()?) } else { None };
            out.push(Statement::Variable(variable, initial));
            if !self.takes(",") {
                return self.expect(";");
            }
        }
    }

    fn choice(&mut self) -> Result<Statement, Untranslated> {
        self.expect("(")?;
        let condition = self.expression()?;
        self.expect(")")?;
        let then = self.block()?;
        let other = if !self.takes("else") {
            Vec::new()
        } else if self.takes("if") {
            vec![self.choice()?]
        } else {
            self.block()?
        };
        Ok(Statement::If(condition, then, other))
    }

    fn switch(&mut self) -> Result<Statement, Untranslated> {
        self.expect("(")?;
        let value = self.expression()?;
        self.expect(")")?;
        self.expect("{")?;
        let mut cases = Vec::new();
        while !self.takes("}") {
            let mut labels = Vec::new();
            loop {
                if self.takes("case") {
                    labels.push(Some(self.expression()?));
                } else if self.takes("default") {
                    labels.push(None);
                } else {
                    break;
                }
                self.expect(":")?;
            }
            let mut body = Vec::new();
            while !(self.comes(0, "}") || self.comes(0, "case") || self.comes(0, "default")) {
                self.statement_into(&mut body)?;
            }
            // Nothing falls through in here.
            match body.last() {
                Some(Statement::Break) => drop(body.pop()),
                Some(Statement::Return(_)) => {}
                _ => return Err(self.unexpected("the end of a case")),
            }
            cases.push((labels, body));
        }
        Ok(Statement::Switch(value, cases))
    }
}

/// The value of an expression of whole numbers.
pub(super) fn integer(expression: &Expression) -> Option<i64> {
    match expression {
        Expression::Number(text, true) => text.parse().ok(),
        Expression::Unary("-", a) => Some(-integer(a)?),
        Expression::Cast(Type::Int, false, a) => integer(a),
        Expression::Binary(operator, a, b) => {
            let (a, b) = (integer(a)?, integer(b)?);
            match *operator {
                "+" => a.checked_add(b),
                "-" => a.checked_sub(b),
                "*" => a.checked_mul(b),
                _ => None,
            }
        }
        _ => None,
    }
}

fn whole(expression: &Expression) -> Option<usize> {
    integer(expression).and_then(|size| size.try_into().ok())
}
