//! The part of C that exported sources are written in, as a tree.

use std::collections::BTreeMap;

/// Type of a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Type {
    Void,
    Int,
    Real,
    /// A structure of that name.
    Struct(String),
}

/// Something with a name and a type: a parameter, a member, a variable.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named {
    pub name: String,
    pub of: Type,
    pub constant: bool,
    pub pointer: bool,
    /// Sizes of an array.
    pub sizes: Vec<usize>,
}

impl Named {
    /// Whether a call hands it back.
    pub fn is_result(&self) -> bool {
        self.pointer && !self.constant
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    /// A number; whether it is an integer.
    Number(String, bool),
    Name(String),
    /// `a[b]`.
    Index(Box<Expression>, Box<Expression>),
    /// `a.b` or `a->b`.
    Member(Box<Expression>, String),
    /// `*a`.
    At(Box<Expression>),
    /// `&a`.
    AddressOf(Box<Expression>),
    /// `-a` or `!a`.
    Unary(&'static str, Box<Expression>),
    Binary(&'static str, Box<Expression>, Box<Expression>),
    Choice(Box<Expression>, Box<Expression>, Box<Expression>),
    Call(Box<Expression>, Vec<Expression>),
    /// `a = b`, `a += b`, `a -= b`.
    Assign(Box<Expression>, &'static str, Box<Expression>),
    /// `a++`, `++a`, `a--`: how much is added, and whether the value is that before.
    Step(Box<Expression>, i8, bool),
    /// `(type)a`; whether it is one to a pointer.
    Cast(Type, bool, Box<Expression>),
}

/// What a variable begins as.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Initial {
    Value(Expression),
    List(Vec<Initial>),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Statement {
    Comment(String),
    Variable(Named, Option<Initial>),
    Do(Expression),
    If(Expression, Vec<Statement>, Vec<Statement>),
    For(Expression, Expression, Expression, Vec<Statement>),
    While(Expression, Vec<Statement>),
    /// Cases by their labels; no label stands for `default`.
    Switch(Expression, Vec<(Vec<Option<Expression>>, Vec<Statement>)>),
    Return(Option<Expression>),
    Break,
    Block(Vec<Statement>),
}

/// What a call needs to know of a function.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Signature {
    pub returns: Type,
    pub parameters: Vec<Named>,
}

#[derive(Clone, Debug)]
pub(super) struct Function {
    pub name: String,
    pub comment: Option<String>,
    pub signature: Signature,
    pub body: Vec<Statement>,
}

/// A constant table.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    pub comment: Option<String>,
    pub variable: Named,
    pub values: Initial,
}

/// A source with its header.
#[derive(Clone, Debug, Default)]
pub(super) struct Source {
    pub functions: Vec<Function>,
    pub constants: Vec<Constants>,
    /// Members of structures.
    pub structures: BTreeMap<String, Vec<Named>>,
    /// Pointers to functions among these, by name.
    pub function_members: BTreeMap<String, Signature>,
    /// Other names of types.
    pub types: BTreeMap<String, Type>,
    /// Constants of enumerations.
    pub enumerated: BTreeMap<String, i64>,
}

impl Expression {
    /// Calls `visit` with every expression in this one, itself first.
    pub fn each<'a>(&'a self, visit: &mut dyn FnMut(&'a Expression)) {
        visit(self);
        match self {
            Self::Number(..) | Self::Name(_) => {}
            Self::Member(a, _)
            | Self::At(a)
            | Self::AddressOf(a)
            | Self::Unary(_, a)
            | Self::Step(a, ..)
            | Self::Cast(_, _, a) => a.each(visit),
            Self::Index(a, b) | Self::Binary(_, a, b) | Self::Assign(a, _, b) => {
                a.each(visit);
                b.each(visit);
            }
            Self::Choice(a, b, c) => {
                a.each(visit);
                b.each(visit);
                c.each(visit);
            }
            Self::Call(f, arguments) => {
                f.each(visit);
                arguments.iter().for_each(|argument| argument.each(visit));
            }
        }
    }

    /// Whether this is the variable of that name.
    pub fn is_named(&self, name: &str) -> bool {
        matches!(self, Self::Name(own) if own == name)
    }
}

/// Calls `visit` with every expression of these statements, but for loops that begin by setting `counter`.
pub(super) fn each_outside<'a>(
    statements: &'a [Statement],
    counter: &str,
    visit: &mut dyn FnMut(&'a Expression),
) {
    for statement in statements {
        match statement {
            Statement::Comment(_) | Statement::Break | Statement::Variable(_, None) => {}
            Statement::Variable(_, Some(value)) => initial(value, visit),
            Statement::Do(value) | Statement::Return(Some(value)) => value.each(visit),
            Statement::Return(None) => {}
            Statement::If(condition, then, other) => {
                condition.each(visit);
                each_outside(then, counter, visit);
                each_outside(other, counter, visit);
            }
            Statement::For(first, condition, next, body) => {
                if matches!(first, Expression::Assign(place, ..) if place.is_named(counter)) {
                    continue;
                }
                [first, condition, next].into_iter().for_each(|e| e.each(visit));
                each_outside(body, counter, visit);
            }
            Statement::While(condition, body) => {
                condition.each(visit);
                each_outside(body, counter, visit);
            }
            Statement::Switch(value, cases) => {
                value.each(visit);
                cases.iter().for_each(|(_, body)| each_outside(body, counter, visit));
            }
            Statement::Block(body) => each_outside(body, counter, visit),
        }
    }
}

fn initial<'a>(value: &'a Initial, visit: &mut dyn FnMut(&'a Expression)) {
    match value {
        Initial::Value(value) => value.each(visit),
        Initial::List(values) => values.iter().for_each(|value| initial(value, visit)),
    }
}
