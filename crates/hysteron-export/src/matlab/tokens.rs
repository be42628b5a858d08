//! Tokens of the exported C, its macros replaced.

use std::collections::BTreeMap;

use super::Untranslated;

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    /// A name or a keyword.
    Name(String),
    /// A number; whether it is an integer.
    Number(String, bool),
    /// An operator or a bracket.
    Mark(&'static str),
    /// The text of a comment, without its delimiters.
    Comment(String),
}

/// Names of numbers that are not whole, and these.
pub(super) type Reals = Vec<(String, Token)>;

/// A macro: its parameters, none for a name alone, and its text.
#[derive(Clone, Debug)]
struct Macro {
    parameters: Option<Vec<String>>,
    body: Vec<Token>,
}

/// Longer ones first.
const MARKS: [&str; 36] = [
    "->", "++", "--", "+=", "-=", "<=", ">=", "==", "!=", "&&", "||", "(", ")", "[", "]", "{", "}", ";", ",",
    "?", ":", "=", "<", ">", "+", "-", "*", "/", "%", "&", "!", ".", "|", "^", "~", "#",
];

/// Tokens of a text, without regard to macros.
fn plain(text: &str) -> Result<Vec<Token>, Untranslated> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let size;
        if let Some(inside) = rest.strip_prefix("/*") {
            let end = inside.find("*/").ok_or_else(|| Untranslated::new("an open comment", rest))?;
            tokens.push(Token::Comment(inside[..end].trim().to_owned()));
            size = end + 4;
        } else if first.is_ascii_alphabetic() || first == '_' {
            size = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
            tokens.push(Token::Name(rest[..size].to_owned()));
        } else if first.is_ascii_digit() {
            size = number_size(rest);
            let digits = rest[..size].trim_end_matches(['u', 'L', 'f']);
            tokens.push(Token::Number(digits.to_owned(), !digits.contains(['.', 'e', 'E'])));
        } else if let Some(mark) = MARKS.iter().find(|mark| rest.starts_with(**mark)) {
            size = mark.len();
            tokens.push(Token::Mark(mark));
        } else {
            return Err(Untranslated::new("a character", rest));
        }
        rest = rest[size..].trim_start();
    }
    Ok(tokens)
}

fn number_size(text: &str) -> usize {
    let mut last = ' ';
    let is_end = |c: char| {
        let exponent = matches!(last, 'e' | 'E') && matches!(c, '+' | '-');
        last = c;
        !(c.is_ascii_alphanumeric() || c == '.' || exponent)
    };
    text.find(is_end).unwrap_or(text.len())
}

/// The tokens of several files, one after the other: conditional parts are left out but for the guard of a
/// header; macros are replaced, except those of a number that is not an integer, which are handed back.
pub(super) fn tokens(files: &[&str]) -> Result<(Vec<Token>, Reals), Untranslated> {
    let mut macros: BTreeMap<String, Macro> = BTreeMap::new();
    let mut out = Vec::new();
    let mut numbers = Reals::new();
    for file in files {
        let mut left_out: Vec<bool> = Vec::new();
        let mut code = String::new();
        for line in file.lines() {
            let Some(directive) = line.trim_start().strip_prefix('#') else {
                if !left_out.contains(&true) {
                    code.push_str(line);
                    code.push('\n');
                }
                continue;
            };
            expand_into(&plain(&std::mem::take(&mut code))?, &macros, &mut out)?;
            if directive.starts_with("if") {
                left_out.push(!directive.starts_with("ifndef"));
            } else if directive.starts_with("endif") {
                left_out.pop();
            } else if let Some(definition) = directive.strip_prefix("define ")
                && !left_out.contains(&true)
            {
                define(definition, &mut macros, &mut numbers)?;
            }
        }
        expand_into(&plain(&code)?, &macros, &mut out)?;
    }
    Ok((out, numbers))
}

fn define(
    definition: &str,
    macros: &mut BTreeMap<String, Macro>,
    numbers: &mut Reals,
) -> Result<(), Untranslated> {
    let size = definition.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
    let (name, rest) = definition.split_at(size.unwrap_or(definition.len()));
    let (parameters, body) = match rest.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
        Some((parameters, body)) => {
            (Some(parameters.split(',').map(|p| p.trim().to_owned()).collect::<Vec<_>>()), body)
        }
        None => (None, rest),
    };
    let body = plain(body)?;
    match (&parameters, &body[..]) {
        (None, [number]) if is_real(number) => numbers.push((name.to_owned(), number.clone())),
        (None, [Token::Mark("("), number, Token::Mark(")")]) if is_real(number) => {
            numbers.push((name.to_owned(), number.clone()));
        }
        (None, [Token::Mark("("), Token::Mark("-"), Token::Number(number, false), Token::Mark(")")]) => {
            numbers.push((name.to_owned(), Token::Number(format!("-{number}"), false)));
        }
        _ => {
            macros.insert(name.to_owned(), Macro { parameters, body });
        }
    }
    Ok(())
}

fn is_real(token: &Token) -> bool {
    matches!(token, Token::Number(_, false)) || *token == Token::Name("HUGE_VAL".into())
}

fn expand_into(
    tokens: &[Token],
    macros: &BTreeMap<String, Macro>,
    out: &mut Vec<Token>,
) -> Result<(), Untranslated> {
    let mut at = 0;
    while at < tokens.len() {
        let own = match &tokens[at] {
            Token::Name(name) => macros.get(name),
            _ => None,
        };
        match own {
            Some(Macro { parameters: None, body }) => expand_into(body, macros, out)?,
            Some(Macro { parameters: Some(parameters), body }) => {
                let (arguments, size) = arguments(&tokens[at + 1..])?;
                let filled: Vec<Token> = body
                    .iter()
                    .flat_map(|token| match token {
                        Token::Name(name) => match parameters.iter().position(|p| p == name) {
                            Some(k) => arguments.get(k).cloned().unwrap_or_default(),
                            None => vec![token.clone()],
                        },
                        _ => vec![token.clone()],
                    })
                    .collect();
                expand_into(&filled, macros, out)?;
                at += size;
            }
            None => out.push(tokens[at].clone()),
        }
        at += 1;
    }
    Ok(())
}

/// The arguments of a macro, and how many tokens they take with their brackets.
fn arguments(tokens: &[Token]) -> Result<(Vec<Vec<Token>>, usize), Untranslated> {
    let mut arguments = vec![Vec::new()];
    let mut depth = 0;
    for (k, token) in tokens.iter().enumerate() {
        match token {
            Token::Mark("(") => depth += 1,
            Token::Mark(")") => depth -= 1,
            Token::Mark(",") if depth == 1 => {
                arguments.push(Vec::new());
                continue;
            }
            _ => {}
        }
        if depth == 0 {
            return Ok((arguments, k + 1));
        }
        if k > 0
            && let Some(last) = arguments.last_mut()
        {
            last.push(token.clone());
        }
    }
    Err(Untranslated::new("an open bracket of a macro", ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn macros_are_replaced_and_numbers_kept() {
        let text = "#ifndef A\n#define A\n#ifdef B\nno\n#endif\n#define N 3\n#define LOW (-0.5)\n\
                    #define OVER(v) ((v) > N)\n/* one */ x[N] = OVER(f(a, 1e-3f)); LOW\n#endif\n";
        let (tokens, numbers) = tokens(&[text]).unwrap();
        let mut said = String::new();
        for token in &tokens {
            match token {
                Token::Name(text) | Token::Number(text, _) => said.push_str(text),
                Token::Mark(mark) => said.push_str(mark),
                Token::Comment(text) => said.push_str(&format!("<{text}>")),
            }
        }
        assert_eq!(said, "<one>x[3]=((f(a,1e-3))>3);LOW");
        assert_eq!(numbers, [("LOW".to_owned(), Token::Number("-0.5".into(), false))]);
    }
}
