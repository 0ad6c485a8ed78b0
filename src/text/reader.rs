//! [`Reader`]: reads formulas, as sums of products of powers, from left to right.

use super::{OfTwo, Term};
use crate::program::Function;

/// Deepest nesting of parentheses and functions that is read.
const DEEPEST: usize = 60;

/// A name in a formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Name<'a> {
    Word(&'a str),
    /// An entry of a list, by its index or name: `q[0]`, `q[cart.x]`.
    Entry {
        list: &'a str,
        key: &'a str,
    },
}

/// A mistake in a formula.
#[derive(Debug)]
pub(crate) struct Mistake {
    /// The number of the character, from 1.
    pub(crate) column: usize,
    pub(crate) problem: String,
}

/// The value of a name, or why there is none.
type Lookup<'a, T> = &'a dyn Fn(Name) -> Result<T, String>;

/// Reads formulas with common names and parts.
pub(crate) struct Reader<'a, T> {
    text: &'a str,
    at: usize,
    lookup: Lookup<'a, T>,
    depth: usize,
    parts: Vec<T>,
}

type Read<T> = Result<T, Mistake>;

impl<'a, T: Term> Reader<'a, T> {
    pub(crate) fn new(lookup: Lookup<'a, T>) -> Self {
        Reader { text: "", at: 0, lookup, depth: 0, parts: Vec::new() }
    }

    /// Reads a formula, in which parts may precede the result.
    pub(crate) fn read(&mut self, text: &'a str) -> Read<T> {
        (self.text, self.at, self.depth) = (text, 0, 0);
        loop {
            let result = self.sum()?;
            match self.next() {
                None => return Ok(result),
                Some(';') => self.at += 1,
                Some(other) => return Err(self.wrong(&format!("`{other}` found where the formula should end"))),
            }
            self.parts.push(result);
        }
    }

    /// Reads a part of the formulas that follow.
    pub(crate) fn define(&mut self, text: &'a str) -> Read<()> {
        let part = self.read(text)?;
        self.parts.push(part);
        Ok(())
    }

    fn wrong(&self, problem: &str) -> Mistake {
        Mistake { column: self.text[..self.at].chars().count() + 1, problem: problem.to_string() }
    }

    /// The next character that is not a space.
    fn next(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let is_there = self.next() == Some(wanted);
        self.at += if is_there { wanted.len_utf8() } else { 0 };
        is_there
    }

    fn expect(&mut self, wanted: char) -> Read<()> {
        if self.take(wanted) { Ok(()) } else { Err(self.wrong(&format!("`{wanted}` is missing"))) }
    }

    fn sum(&mut self) -> Read<T> {
        let mut sum = self.product()?;
        loop {
            if self.take('+') {
                sum = sum + self.product()?;
            } else if self.take('-') {
                sum = sum - self.product()?;
            } else {
                return Ok(sum);
            }
        }
    }

    fn product(&mut self) -> Read<T> {
        let mut product = self.signed()?;
        loop {
            if self.take('*') {
                product = product * self.signed()?;
            } else if self.take('/') {
                product = product / self.signed()?;
            } else {
                return Ok(product);
            }
        }
    }

    /// A power preceded by a sign: −x² is −(x²).
    fn signed(&mut self) -> Read<T> {
        let mut is_negative = false;
        while self.take('-') {
            is_negative = !is_negative;
        }
        let power = self.power()?;
        Ok(if is_negative { -power } else { power })
    }

    fn power(&mut self) -> Read<T> {
        let base = self.whole()?;
        if !self.take('^') {
            return Ok(base);
        }
        let is_negative = self.take('-');
        let n = self.whole()?;
        let n = self.exponent(if is_negative { -n } else { n })?;
        // The conversion is exact: the bounds ±i32::MAX are representable in both types.
        let is_integer = n.fract() == 0.0 && n.abs() <= f64::from(i32::MAX);
        Ok(if is_integer { base.integer_power(n as i32) } else { base.power(n) })
    }

    fn exponent(&self, n: T) -> Read<f64> {
        n.constant().ok_or_else(|| self.wrong("the exponent must be a number; x ^ y is exp(y * ln(x))"))
    }

    fn whole(&mut self) -> Read<T> {
        match self.next() {
            Some('(') => {
                self.at += 1;
                self.within(Self::sum)
            }
            Some('`') => {
                let (name, after) = self.quoted(self.at)?;
                let result = self.look_up(Name::Word(name))?;
                self.at = after;
                Ok(result)
            }
            Some('$') => self.part(),
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.word(),
            Some(other) => Err(self.wrong(&format!("`{other}` found where a number, a name or `(` is expected"))),
            None => Err(self.wrong("the formula ends too early")),
        }
    }

    /// The name in backticks that begins at `from`, and the place after it.
    fn quoted(&self, from: usize) -> Read<(&'a str, usize)> {
        let name = &self.text[from + 1..];
        match name.find('`') {
            Some(end) => Ok((&name[..end], from + end + 2)),
            None => Err(self.wrong("this backtick is not closed")),
        }
    }

    fn part(&mut self) -> Read<T> {
        let digits = &self.text[self.at + 1..];
        let digits = &digits[..digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len())];
        let part = digits.parse().ok().and_then(|which: usize| self.parts.get(which.checked_sub(1)?)).copied();
        let part = part.ok_or_else(|| self.wrong(&format!("no part `${digits}` precedes it")))?;
        self.at += 1 + digits.len();
        Ok(part)
    }

    fn within<R>(&mut self, read: impl FnOnce(&mut Self) -> Read<R>) -> Read<R> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.wrong(&format!("more than {DEEPEST} nested parentheses")));
        }
        let result = read(self)?;
        self.depth -= 1;
        self.expect(')')?;
        Ok(result)
    }

    fn number(&mut self) -> Read<T> {
        let rest = &self.text[self.at..];
        let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let mut length = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        if let Some(exponent) = rest[length..].strip_prefix(['e', 'E']) {
            let size = exponent.strip_prefix(['-', '+']).unwrap_or(exponent);
            // Without digits, the letter does not belong to the number.
            length = if digits(size) > 0 { rest.len() - size.len() + digits(size) } else { length };
        }
        match rest[..length].parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.at += length;
                Ok(number.into())
            }
            _ => Err(self.wrong("this is not a finite number")),
        }
    }

    fn word(&mut self) -> Read<T> {
        let rest = &self.text[self.at..];
        let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let (word, after) = rest.split_at(length);
        match after.trim_start().chars().next() {
            Some('(') => self.call(word),
            Some('[') => self.entry(word),
            _ => {
                let result = self.look_up(Name::Word(word))?;
                self.at += length;
                Ok(result)
            }
        }
    }

    /// An entry of a list, whose key ends at the next bracket or is in backticks.
    fn entry(&mut self, list: &'a str) -> Read<T> {
        let start = self.at;
        self.at += list.len();
        self.expect('[')?;
        let key = if self.next() == Some('`') {
            let (key, after) = self.quoted(self.at)?;
            self.at = after;
            key
        } else {
            let rest = &self.text[self.at..];
            let key = &rest[..rest.find(']').ok_or_else(|| self.wrong("`]` is missing"))?];
            self.at += key.len();
            key.trim_end()
        };
        self.expect(']')?;
        (self.lookup)(Name::Entry { list, key }).map_err(|problem| {
            self.at = start;
            self.wrong(&problem)
        })
    }

    fn call(&mut self, word: &str) -> Read<T> {
        if let Some(function) = Function::NAMED.into_iter().find(|function| function.name() == word) {
            self.open(word)?;
            return Ok(self.within(Self::sum)?.function(function));
        }
        if let Some((_, function)) = OfTwo::ALL.into_iter().find(|(name, _)| *name == word) {
            self.open(word)?;
            let [x, y] = self.within(Self::pair)?;
            return Ok(x.of_two(function, y));
        }
        if word == "pow" {
            self.open(word)?;
            let [x, n] = self.within(Self::pair)?;
            return Ok(x.power(self.exponent(n)?));
        }
        if word == "if" {
            self.open(word)?;
            return self.within(Self::choice);
        }
        let of_one = Function::NAMED.map(Function::name).into_iter();
        let of_two = OfTwo::ALL.map(|(name, _)| name.to_string());
        let known: Vec<String> = of_one.chain(of_two).chain(["pow", "if"].map(str::to_string)).collect();
        Err(self.wrong(&format!("unknown function `{word}`; known functions are {}", known.join(", "))))
    }

    fn open(&mut self, word: &str) -> Read<()> {
        self.at += word.len();
        self.expect('(')
    }

    fn pair(&mut self) -> Read<[T; 2]> {
        let x = self.sum()?;
        self.expect(',')?;
        Ok([x, self.sum()?])
    }

    /// `x < y, a, b`, also with `>`, `<=` and `>=`.
    fn choice(&mut self) -> Read<T> {
        let x = self.sum()?;
        let is_less = match self.next() {
            Some('<') => true,
            Some('>') => false,
            _ => return Err(self.wrong("a comparison such as `x < y` is expected")),
        };
        self.at += 1;
        let has_equality = self.take('=');
        let y = self.sum()?;
        self.expect(',')?;
        let [a, b] = self.pair()?;
        // x ≤ y unless y < x.
        let (x, y) = if is_less == has_equality { (y, x) } else { (x, y) };
        Ok(if has_equality { x.if_less(y, b, a) } else { x.if_less(y, a, b) })
    }

    fn look_up(&self, name: Name) -> Read<T> {
        (self.lookup)(name).map_err(|problem| self.wrong(&problem))
    }
}
