//! From the tree to MATLAB: expressions.
//!
//! What MATLAB has no expression for (a choice, a call that hands back more than one value, `&&` whose right
//! side needs either) is put into statements before the one that uses it.

use super::Untranslated;
use super::syntax::{Expression, Named, Signature, Type};
use super::write::Writer;

/// An expression in MATLAB with its precedence there.
#[derive(Clone, Debug)]
pub(super) struct Text {
    pub text: String,
    level: u8,
}

/// Precedences: of `||`, of `&&`, of comparisons, of sums, of products, of signs, of all that is closed.
const OR: u8 = 0;
const AND: u8 = 1;
const COMPARISON: u8 = 2;
const SUM: u8 = 3;
const PRODUCT: u8 = 4;
const SIGN: u8 = 5;
const CLOSED: u8 = 6;

/// Functions of `<math.h>`, and in MATLAB; those of `real_` are in the template, because MATLAB's own become
/// complex where C's are not a number.
const FUNCTIONS: [(&str, &str); 10] = [
    ("fabs", "abs"),
    ("exp", "exp"),
    ("tanh", "tanh"),
    ("tan", "tan"),
    ("atan", "atan"),
    ("sqrt", "real_sqrt"),
    ("log", "real_log"),
    ("log1p", "real_log1p"),
    ("pow", "real_pow"),
    ("floor", "floor"),
];

fn closed(text: impl Into<String>) -> Text {
    Text { text: text.into(), level: CLOSED }
}

impl Text {
    /// The text, in brackets where it binds less than `level`.
    fn at_least(&self, level: u8) -> String {
        if self.level >= level { self.text.clone() } else { format!("({})", self.text) }
    }

    /// Its negation.
    pub fn negated(&self) -> String {
        format!("~{}", self.at_least(CLOSED))
    }
}

impl Writer<'_> {
    /// An expression as a condition: a pointer is one where it points to something.
    pub fn condition(&mut self, expression: &Expression) -> Result<Text, Untranslated> {
        match expression {
            Expression::Name(name) if self.variable(name).is_some_and(|v| v.pointer) => {
                Ok(Text { text: format!("~isempty({})", self.renamed(name)), level: SIGN })
            }
            _ => self.value(expression),
        }
    }

    pub fn value(&mut self, expression: &Expression) -> Result<Text, Untranslated> {
        match expression {
            Expression::Number(text, _) => Ok(closed(text)),
            Expression::Name(name) => self.name(name),
            Expression::Index(..) => self.element(expression),
            Expression::Member(owner, member) => {
                let owner = self.value(owner)?;
                Ok(closed(format!("{}.{}", owner.text, self.renamed(member))))
            }
            Expression::At(a) | Expression::AddressOf(a) => self.value(a),
            Expression::Unary("!", a) => {
                let a = self.condition(a)?;
                Ok(Text { text: a.negated(), level: SIGN })
            }
            Expression::Unary(sign, a) => {
                let a = self.value(a)?;
                Ok(Text { text: format!("{sign}{}", a.at_least(CLOSED)), level: SIGN })
            }
            Expression::Binary(operator @ ("&&" | "||"), a, b) => self.logical(operator, a, b),
            Expression::Binary(operator, a, b) => self.binary(operator, a, b),
            Expression::Choice(..) => {
                let place = self.fresh();
                self.assign(&place, expression)?;
                Ok(closed(place))
            }
            Expression::Call(function, arguments) => self.call(function, arguments, None).map(closed),
            Expression::Step(place, by, false) => {
                let place = self.value(place)?;
                self.step(&place.text, *by);
                Ok(place)
            }
            Expression::Cast(_, true, _) => Ok(closed("[]")),
            Expression::Cast(Type::Int, _, a) if !self.is_whole(a) => {
                let a = self.value(a)?;
                Ok(closed(format!("fix({})", a.text)))
            }
            Expression::Cast(_, _, a) => self.value(a),
            Expression::Assign(..) | Expression::Step(..) => {
                Err(Untranslated::new("a value without an assignment", &format!("{expression:?}")))
            }
        }
    }

    fn name(&mut self, name: &str) -> Result<Text, Untranslated> {
        if let Some(other) = self.stands_for(name) {
            return self.value(&other);
        }
        if self.variable(name).is_some() {
            return Ok(closed(self.renamed(name)));
        }
        if name == "HUGE_VAL" {
            return Ok(closed("Inf"));
        }
        if let Some(value) = self.source.enumerated.get(name) {
            let level = if *value < 0 { SIGN } else { CLOSED };
            return Ok(Text { text: value.to_string(), level });
        }
        if let Some(number) = self.number(name) {
            return Ok(closed(number));
        }
        if self.source.functions.iter().any(|f| f.name == name) {
            return Ok(closed(format!("@{name}")));
        }
        Err(Untranslated::new("a declared name", name))
    }

    /// `a[i][j]` is `a(i + 1, j + 1)`.
    fn element(&mut self, expression: &Expression) -> Result<Text, Untranslated> {
        let (mut indices, mut base) = (Vec::new(), expression.clone());
        loop {
            base = match base {
                Expression::Index(inner, index) => {
                    indices.push(*index);
                    *inner
                }
                Expression::Name(name) if self.stands_for(&name).is_some() => {
                    self.stands_for(&name).unwrap_or(Expression::Name(name))
                }
                other => {
                    base = other;
                    break;
                }
            };
        }
        let mut places = Vec::new();
        for index in indices.iter().rev() {
            places.push(match index {
                Expression::Binary("-", a, b) if **b == Expression::Number("1".into(), true) => {
                    self.value(a)?.text
                }
                _ => match super::parse::integer(index) {
                    Some(index) => (index + 1).to_string(),
                    None => format!("{} + 1", self.value(index)?.at_least(SUM)),
                },
            });
        }
        let base = self.value(&base)?;
        Ok(closed(format!("{}({})", base.text, places.join(", "))))
    }

    fn logical(&mut self, operator: &str, a: &Expression, b: &Expression) -> Result<Text, Untranslated> {
        let level = if operator == "&&" { AND } else { OR };
        let left = self.condition(a)?;
        let before = self.mark();
        let right = self.condition(b)?;
        let needs = self.since(before);
        if needs.is_empty() {
            let text = format!("{} {operator} {}", left.at_least(level), right.at_least(level + 1));
            return Ok(Text { text, level });
        }
        let place = self.fresh();
        self.line(format!("{place} = {};", left.text));
        self.line(format!("if {}{place}", if operator == "&&" { "" } else { "~" }));
        self.deeper(needs);
        self.inside(|writer| writer.line(format!("{place} = {};", right.text)));
        self.line("end");
        Ok(closed(place))
    }

    fn binary(&mut self, operator: &str, a: &Expression, b: &Expression) -> Result<Text, Untranslated> {
        let whole = self.is_whole(a) && self.is_whole(b);
        let (left, right) = (self.value(a)?, self.value(b)?);
        Ok(match operator {
            "&" => closed(format!("bitand({}, {})", left.text, right.text)),
            "%" => closed(format!("rem({}, {})", left.text, right.text)),
            "/" if whole => {
                closed(format!("fix({} / {})", left.at_least(PRODUCT), right.at_least(PRODUCT + 1)))
            }
            "+" | "-" | "*" | "/" => {
                let level = if matches!(operator, "+" | "-") { SUM } else { PRODUCT };
                let text = format!("{} {operator} {}", left.at_least(level), right.at_least(level + 1));
                Text { text, level }
            }
            _ => {
                let operator = if operator == "!=" { "~=" } else { operator };
                let text = format!("{} {operator} {}", left.at_least(SUM), right.at_least(SUM));
                Text { text, level: COMPARISON }
            }
        })
    }

    /// A call. The values that it hands back through pointers go where these point, its own to `place`, where
    /// that is given; the text of its value.
    pub fn call(
        &mut self,
        function: &Expression,
        arguments: &[Expression],
        place: Option<&str>,
    ) -> Result<String, Untranslated> {
        if let Expression::Name(name) = function
            && let Some((_, own)) = FUNCTIONS.iter().find(|(c, _)| c == name)
        {
            let arguments: Result<Vec<String>, _> =
                arguments.iter().map(|a| self.value(a).map(|a| a.text)).collect();
            return Ok(format!("{own}({})", arguments?.join(", ")));
        }
        let (signature, name) = self.callee(function)?;
        let mut inputs = vec!["par".to_owned()];
        let mut outputs = Vec::new();
        for (parameter, argument) in signature.parameters.iter().zip(arguments) {
            let text = self.value(argument)?.text;
            if parameter.is_result() {
                outputs.push(if text == "[]" { "~".to_owned() } else { text.clone() });
            }
            inputs.push(text);
        }
        let call = format!("{name}({})", inputs.join(", "));
        if outputs.is_empty() && signature.returns != Type::Void {
            return Ok(call);
        }
        let mut own = String::new();
        if signature.returns != Type::Void {
            own = place.map_or_else(|| self.fresh(), str::to_owned);
            outputs.insert(0, own.clone());
        }
        match &outputs[..] {
            [] => self.line(format!("{call};")),
            [one] => self.line(format!("{one} = {call};")),
            more => self.line(format!("[{}] = {call};", more.join(", "))),
        }
        Ok(own)
    }

    fn callee(&mut self, function: &Expression) -> Result<(Signature, String), Untranslated> {
        let unknown = || Untranslated::new("a declared function", &format!("{function:?}"));
        match function {
            Expression::Name(name) => {
                let found = self.source.functions.iter().find(|f| f.name == *name).ok_or_else(unknown)?;
                Ok((found.signature.clone(), name.clone()))
            }
            Expression::Member(_, member) => {
                let signature = self.source.function_members.get(member).ok_or_else(unknown)?.clone();
                Ok((signature, self.value(function)?.text))
            }
            _ => Err(unknown()),
        }
    }

    /// Whether C takes an expression for a whole number.
    fn is_whole(&self, expression: &Expression) -> bool {
        let is_whole = |named: &Named| named.of == Type::Int;
        match expression {
            Expression::Number(_, whole) => *whole,
            Expression::Name(name) => match self.stands_for(name) {
                Some(other) => self.is_whole(&other),
                None => {
                    self.variable(name).is_some_and(is_whole) || self.source.enumerated.contains_key(name)
                }
            },
            Expression::Member(_, member) => {
                let mut all = self.source.structures.values().flatten();
                all.any(|named| named.name == *member && is_whole(named))
            }
            Expression::Index(a, _) | Expression::At(a) | Expression::AddressOf(a) => self.is_whole(a),
            Expression::Unary(operator, a) => *operator == "!" || self.is_whole(a),
            Expression::Binary("+" | "-" | "*" | "/", a, b) | Expression::Choice(_, a, b) => {
                self.is_whole(a) && self.is_whole(b)
            }
            Expression::Binary(..) => true,
            Expression::Call(function, _) => match &**function {
                Expression::Name(name) => {
                    let mut all = self.source.functions.iter();
                    all.any(|f| f.name == *name && f.signature.returns == Type::Int)
                }
                _ => false,
            },
            Expression::Assign(a, ..) | Expression::Step(a, ..) => self.is_whole(a),
            Expression::Cast(of, ..) => *of == Type::Int,
        }
    }
}
