//! From the tree to MATLAB: functions and statements.

use std::collections::BTreeMap;

use super::Untranslated;
use super::parse::integer;
use super::syntax::{Expression, Function, Initial, Named, Source, Statement, Type, each_outside};

/// Words that are no names in MATLAB or Octave, or have a meaning in the functions written here.
const TAKEN: &str = " end function otherwise elseif parfor spmd global persistent classdef try catch until \
                     do par result ";

/// Lines with their depths.
pub(super) type Lines = Vec<(usize, String)>;

/// Writes functions.
pub(super) struct Writer<'a> {
    pub source: &'a Source,
    /// Names of numbers among the parameters.
    numbers: &'a BTreeMap<String, String>,
    lines: Lines,
    depth: usize,
    variables: BTreeMap<String, Named>,
    aliases: BTreeMap<String, Expression>,
    body: &'a [Statement],
    count: usize,
}

impl<'a> Writer<'a> {
    pub fn new(source: &'a Source, numbers: &'a BTreeMap<String, String>) -> Self {
        Self {
            source,
            numbers,
            lines: Vec::new(),
            depth: 0,
            variables: BTreeMap::new(),
            aliases: BTreeMap::new(),
            body: &[],
            count: 0,
        }
    }

    /// All functions, one after the other.
    pub fn functions(mut self) -> Result<String, Untranslated> {
        let source = self.source;
        for function in &source.functions {
            self.function(function)?;
        }
        let line = |(depth, text): &(usize, String)| {
            if text.is_empty() { "\n".to_owned() } else { format!("{}{text}\n", "    ".repeat(*depth)) }
        };
        Ok(self.lines.iter().map(line).collect())
    }

    fn function(&mut self, function: &'a Function) -> Result<(), Untranslated> {
        let signature = &function.signature;
        self.variables = signature.parameters.iter().map(|p| (p.name.clone(), p.clone())).collect();
        self.aliases.clear();
        self.body = &function.body;
        self.count = 0;
        let mut outputs: Vec<String> =
            signature.parameters.iter().filter(|p| p.is_result()).map(|p| self.renamed(&p.name)).collect();
        if signature.returns != Type::Void {
            outputs.insert(0, "result".into());
        }
        let outputs = match &outputs[..] {
            [] => String::new(),
            [one] => format!("{one} = "),
            more => format!("[{}] = ", more.join(", ")),
        };
        let inputs: String =
            signature.parameters.iter().map(|p| format!(", {}", self.renamed(&p.name))).collect();
        self.line("");
        self.line(format!("function {outputs}{}(par{inputs})", function.name));
        if let Some(comment) = &function.comment {
            self.comment(comment);
        }
        self.inside(|writer| writer.statements(&function.body))?;
        if self.lines.last().is_some_and(|(depth, text)| *depth == 1 && text == "return;") {
            self.lines.pop();
        }
        self.line("end");
        Ok(())
    }

    /// A line at the present depth.
    pub fn line(&mut self, text: impl Into<String>) {
        self.lines.push((self.depth, text.into()));
    }

    pub fn mark(&self) -> usize {
        self.lines.len()
    }

    /// Takes back the lines since a mark.
    pub fn since(&mut self, mark: usize) -> Lines {
        self.lines.split_off(mark)
    }

    /// Puts lines in, one level deeper than they were.
    pub fn deeper(&mut self, lines: Lines) {
        self.lines.extend(lines.into_iter().map(|(depth, text)| (depth + 1, text)));
    }

    /// What `write` writes, one level deeper.
    pub fn inside<R>(&mut self, write: impl FnOnce(&mut Self) -> R) -> R {
        self.depth += 1;
        let result = write(self);
        self.depth -= 1;
        result
    }

    /// A variable of a name that is not used yet.
    pub fn fresh(&mut self) -> String {
        self.count += 1;
        format!("t_{}", self.count)
    }

    pub fn variable(&self, name: &str) -> Option<&Named> {
        self.variables.get(name)
    }

    /// The expression that a local pointer stands for.
    pub fn stands_for(&self, name: &str) -> Option<Expression> {
        self.aliases.get(name).cloned()
    }

    /// The place of a number among the parameters.
    pub fn number(&self, name: &str) -> Option<String> {
        self.numbers.get(name).map(|own| format!("par.{own}"))
    }

    pub fn renamed(&self, name: &str) -> String {
        if TAKEN.contains(&format!(" {name} ")) { format!("{name}_") } else { name.to_owned() }
    }

    pub fn step(&mut self, place: &str, by: i8) {
        let sign = if by < 0 { '-' } else { '+' };
        self.line(format!("{place} = {place} {sign} 1;"));
    }

    fn comment(&mut self, text: &str) {
        for line in text.lines() {
            self.line(format!("% {}", line.trim().trim_start_matches("* ")).trim_end());
        }
    }

    fn statements(&mut self, statements: &'a [Statement]) -> Result<(), Untranslated> {
        statements.iter().try_for_each(|statement| self.statement(statement))
    }

    fn statement(&mut self, statement: &'a Statement) -> Result<(), Untranslated> {
        match statement {
            Statement::Comment(text) => self.comment(text),
            Statement::Variable(variable, initial) => self.declare(variable, initial.as_ref())?,
            Statement::Do(expression) => self.act(expression)?,
            Statement::If(condition, then, other) => {
                let condition = self.condition(condition)?.text;
                self.choice("if", &condition, then, other)?;
                self.line("end");
            }
            Statement::For(first, condition, next, body) => {
                self.count_through(first, condition, next, body)?
            }
            Statement::While(condition, body) => self.repeat(condition, body, None)?,
            Statement::Switch(value, cases) => self.switch(value, cases)?,
            Statement::Return(value) => {
                if let Some(value) = value {
                    self.assign("result", value)?;
                }
                self.line("return;");
            }
            Statement::Break => self.line("break;"),
            Statement::Block(body) => self.statements(body)?,
        }
        Ok(())
    }

    /// A branch, and what else there is, up to the `end`.
    fn choice(
        &mut self,
        word: &str,
        condition: &str,
        then: &'a [Statement],
        other: &'a [Statement],
    ) -> Result<(), Untranslated> {
        self.line(format!("{word} {condition}"));
        self.inside(|writer| writer.statements(then))?;
        if let [Statement::If(next, then, other)] = other {
            let before = self.mark();
            let condition = self.condition(next)?.text;
            if self.mark() == before {
                return self.choice("elseif", &condition, then, other);
            }
            self.since(before);
        }
        if !other.is_empty() {
            self.line("else");
            self.inside(|writer| writer.statements(other))?;
        }
        Ok(())
    }

    fn declare(&mut self, variable: &Named, initial: Option<&Initial>) -> Result<(), Untranslated> {
        let name = self.renamed(&variable.name);
        if variable.pointer {
            let Some(Initial::Value(value)) = initial else {
                return Err(Untranslated::new("a pointer to something", &variable.name));
            };
            self.aliases.insert(variable.name.clone(), value.clone());
            return Ok(());
        }
        self.variables.insert(variable.name.clone(), variable.clone());
        match initial {
            Some(Initial::Value(value)) => self.assign(&name, value),
            Some(Initial::List(rows)) => {
                let list = self.list(rows)?;
                self.line(format!("{name} = {list};"));
                Ok(())
            }
            None => {
                let nothing = nothing(self.source, variable)?;
                self.line(format!("{name} = {nothing};"));
                Ok(())
            }
        }
    }

    fn list(&mut self, rows: &[Initial]) -> Result<String, Untranslated> {
        let mut out = Vec::new();
        let mut separator = ", ";
        for row in rows {
            out.push(match row {
                Initial::Value(value) => self.value(value)?.text,
                Initial::List(inner) => {
                    separator = "; ";
                    self.list(inner)?.trim_matches(['[', ']']).to_owned()
                }
            });
        }
        Ok(format!("[{}]", out.join(separator)))
    }

    /// An expression for what it does.
    fn act(&mut self, expression: &Expression) -> Result<(), Untranslated> {
        match expression {
            Expression::Assign(place, "=", value) => {
                let place = self.value(place)?.text;
                self.assign(&place, value)?;
            }
            Expression::Assign(place, operator, value) => {
                let place = self.value(place)?.text;
                let value = Expression::Binary(
                    if *operator == "+=" { "+" } else { "-" },
                    Box::new(Expression::Number(place.clone(), false)),
                    value.clone(),
                );
                let value = self.value(&value)?.text;
                self.line(format!("{place} = {value};"));
            }
            Expression::Step(place, by, _) => {
                let place = self.value(place)?.text;
                self.step(&place, *by);
            }
            Expression::Call(function, arguments) => drop(self.call(function, arguments, Some("~"))?),
            Expression::Cast(Type::Void, _, inner) => match &**inner {
                Expression::Name(_) => {}
                other => self.act(other)?,
            },
            _ => return Err(Untranslated::new("a statement", &format!("{expression:?}"))),
        }
        Ok(())
    }

    /// Sets a place to a value.
    pub fn assign(&mut self, place: &str, value: &Expression) -> Result<(), Untranslated> {
        if let Expression::Choice(condition, then, other) = value {
            let condition = self.condition(condition)?;
            let before = self.mark();
            self.inside(|writer| writer.assign(place, then))?;
            let then = self.since(before);
            self.inside(|writer| writer.assign(place, other))?;
            let other = self.since(before);
            match (then.is_empty(), other.is_empty()) {
                (true, true) => {}
                (true, false) => {
                    self.line(format!("if {}", condition.negated()));
                    self.lines.extend(other);
                    self.line("end");
                }
                (false, _) => {
                    self.line(format!("if {}", condition.text));
                    self.lines.extend(then);
                    if !other.is_empty() {
                        self.line("else");
                        self.lines.extend(other);
                    }
                    self.line("end");
                }
            }
            return Ok(());
        }
        let text = match value {
            Expression::Call(function, arguments) => self.call(function, arguments, Some(place))?,
            _ => self.value(value)?.text,
        };
        if text != place {
            self.line(format!("{place} = {text};"));
        }
        Ok(())
    }

    fn count_through(
        &mut self,
        first: &'a Expression,
        condition: &'a Expression,
        next: &'a Expression,
        body: &'a [Statement],
    ) -> Result<(), Untranslated> {
        if let Some((counter, from, by, to)) = self.counted(first, condition, next, body)? {
            let by = if by < 0 { ":-1" } else { "" };
            self.line(format!("for {counter} = {from}{by}:{to}"));
            self.inside(|writer| writer.statements(body))?;
            self.line("end");
            return Ok(());
        }
        self.act(first)?;
        self.repeat(condition, body, Some(next))
    }

    /// Counter, first value, step and last value of a loop that MATLAB counts as C does: its end stands, and
    /// neither its body nor anything behind it asks more of the counter.
    fn counted(
        &mut self,
        first: &Expression,
        condition: &Expression,
        next: &Expression,
        body: &'a [Statement],
    ) -> Result<Option<(String, String, i8, String)>, Untranslated> {
        let (Expression::Assign(place, "=", from), Expression::Step(_, by, _)) = (first, next) else {
            return Ok(None);
        };
        let (Expression::Name(counter), Expression::Binary(operator, left, end)) = (&**place, condition)
        else {
            return Ok(None);
        };
        let mut elsewhere = left.is_named(counter);
        each_outside(self.body, counter, &mut |e| elsewhere &= !e.is_named(counter));
        let mut stands = matches!(**end, Expression::Name(_)) || integer(end).is_some();
        each_outside(body, "", &mut |e| match e {
            Expression::Assign(place, ..) | Expression::Step(place, ..) | Expression::AddressOf(place) => {
                stands &= place != end && !place.is_named(counter);
            }
            _ => {}
        });
        let beyond = match *operator {
            "<" => -1,
            ">" => 1,
            "<=" | ">=" => 0,
            _ => return Ok(None),
        };
        if !elsewhere || !stands {
            return Ok(None);
        }
        let from = match integer(from) {
            Some(from) => from.to_string(),
            None => self.value(from)?.text,
        };
        let to = match integer(end) {
            Some(end) => (end + beyond).to_string(),
            None if beyond == 0 => self.value(end)?.text,
            None => format!("{} {} 1", self.value(end)?.text, if beyond < 0 { '-' } else { '+' }),
        };
        Ok(Some((self.renamed(counter), from, *by, to)))
    }

    fn repeat(
        &mut self,
        condition: &'a Expression,
        body: &'a [Statement],
        next: Option<&'a Expression>,
    ) -> Result<(), Untranslated> {
        let before = self.mark();
        let holds = self.condition(condition)?;
        let needs = self.since(before);
        if needs.is_empty() {
            self.line(format!("while {}", holds.text));
        } else {
            self.line("while true");
            self.deeper(needs);
            self.inside(|writer| {
                writer.line(format!("if {}", holds.negated()));
                writer.inside(|writer| writer.line("break;"));
                writer.line("end");
            });
        }
        self.inside(|writer| {
            writer.statements(body)?;
            next.map_or(Ok(()), |next| writer.act(next))
        })?;
        self.line("end");
        Ok(())
    }

    fn switch(
        &mut self,
        value: &'a Expression,
        cases: &'a [(Vec<Option<Expression>>, Vec<Statement>)],
    ) -> Result<(), Untranslated> {
        let place = self.fresh();
        self.assign(&place, value)?;
        let mut word = "if";
        for (k, (labels, body)) in cases.iter().enumerate() {
            if labels.contains(&None) {
                if k + 1 < cases.len() {
                    return Err(Untranslated::new("a default that comes last", ""));
                }
                self.line("else");
            } else {
                let mut is_one = Vec::new();
                for label in labels.iter().flatten() {
                    is_one.push(format!("{place} == {}", self.value(label)?.text));
                }
                self.line(format!("{word} {}", is_one.join(" || ")));
                word = "elseif";
            }
            self.inside(|writer| writer.statements(body))?;
        }
        self.line("end");
        Ok(())
    }
}

/// What a variable is where C leaves open what it begins as.
pub(super) fn nothing(source: &Source, variable: &Named) -> Result<String, Untranslated> {
    Ok(match (&variable.sizes[..], &variable.of) {
        ([], Type::Struct(name)) => {
            let unknown = || Untranslated::new("a structure", name);
            let members = source.structures.get(name).ok_or_else(unknown)?;
            let members: Result<Vec<String>, _> = members
                .iter()
                .map(|member| nothing(source, member).map(|value| format!("'{}', {value}", member.name)))
                .collect();
            format!("struct({})", members?.join(", "))
        }
        ([], _) => "0".into(),
        ([size], Type::Int | Type::Real) => format!("zeros(1, {size})"),
        ([rows, columns], Type::Int | Type::Real) => format!("zeros({rows}, {columns})"),
        _ => return Err(Untranslated::new("an array of numbers", &variable.name)),
    })
}
