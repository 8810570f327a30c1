//! Arithmetic as it stands in `*PARAMETER` and in `--quantity`: a small safe evaluator.
//! Never here: where names get their values.

/// An expression that has been parsed.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// A number.
    Number(f64),
    /// Text in quotes.
    Text(String),
    /// A name.
    Name(String),
    /// `-x`.
    Negative(Box<Expression>),
    /// `x op y` with `+ - * / ^ %` (`^` is written `**` too).
    Binary(char, Box<Expression>, Box<Expression>),
    /// `f(x, …)`.
    Call(String, Vec<Expression>),
    /// `f(raw text)` of a function that takes a name as it stands.
    Raw(String, String),
}

/// What an expression amounts to.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// Text.
    Text(String),
}

/// Why an expression cannot be read or evaluated, and where in its text.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionError {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
    /// In words.
    pub message: String,
}

/// Functions of one and two numbers, as Python's `math` names them.
const FUNCTIONS: &[&str] = &[
    "abs", "acos", "asin", "atan", "atan2", "ceil", "cos", "cosh", "exp", "float", "floor", "hypot", "int", "log",
    "log10", "max", "min", "pow", "round", "sin", "sinh", "sqrt", "tan", "tanh",
];

/// How deep brackets and signs may nest.
const DEEPEST: usize = 100;

impl Expression {
    /// Parses a text. Functions named in `raw` take what stands in their brackets as a name, not as arithmetic.
    ///
    /// # Errors
    /// Where the text is no expression.
    pub fn parse(text: &str, raw: &[&str]) -> Result<Expression, ExpressionError> {
        let mut reader = Reader { text, at: 0, raw, depth: 0 };
        let expression = reader.sum()?;
        reader.blanks();
        if reader.at < text.len() { Err(reader.fault("nothing more was expected here")) } else { Ok(expression) }
    }

    /// The value, with names looked up by `name` and raw functions by `raw`.
    ///
    /// # Errors
    /// In words: an unknown name, a result that is not finite, text in arithmetic.
    pub fn evaluate(
        &self,
        name: &dyn Fn(&str) -> Result<Value, String>,
        raw: &dyn Fn(&str, &str) -> Result<f64, String>,
    ) -> Result<Value, String> {
        let number = |e: &Expression| e.evaluate(name, raw)?.number();
        let value = match self {
            Expression::Number(value) => *value,
            Expression::Text(text) => return Ok(Value::Text(text.clone())),
            Expression::Name(text) => return name(text),
            Expression::Negative(inner) => -number(inner)?,
            Expression::Binary(op, a, b) => binary(*op, number(a)?, number(b)?),
            Expression::Call(function, arguments) => {
                let values = arguments.iter().map(number).collect::<Result<Vec<_>, _>>()?;
                call(function, &values)?
            }
            Expression::Raw(function, text) => raw(function, text)?,
        };
        if value.is_finite() {
            Ok(Value::Number(value))
        } else {
            Err(format!("the result is {value}, not a finite number"))
        }
    }
}

impl Value {
    /// The number, if it is one.
    ///
    /// # Errors
    /// In words, if it is text.
    pub fn number(&self) -> Result<f64, String> {
        match self {
            Value::Number(value) => Ok(*value),
            Value::Text(text) => Err(format!("`{text}` is text, not a number")),
        }
    }

    /// The text that takes the place of `<name>`: whole numbers without a point, others in the shortest form that reads
    /// back to the same number.
    pub fn text(&self) -> String {
        match self {
            Value::Number(value) => format!("{value}"),
            Value::Text(text) => text.clone(),
        }
    }
}

fn binary(op: char, a: f64, b: f64) -> f64 {
    match op {
        '+' => a + b,
        '-' => a - b,
        '*' => a * b,
        '/' => a / b,
        '%' => a.rem_euclid(b),
        _ => a.powf(b),
    }
}

fn call(function: &str, arguments: &[f64]) -> Result<f64, String> {
    Ok(match (function, arguments) {
        ("abs", [x]) => x.abs(),
        ("acos", [x]) => x.acos(),
        ("asin", [x]) => x.asin(),
        ("atan", [x]) => x.atan(),
        ("atan2", [y, x]) => y.atan2(*x),
        ("ceil", [x]) => x.ceil(),
        ("cos", [x]) => x.cos(),
        ("cosh", [x]) => x.cosh(),
        ("exp", [x]) => x.exp(),
        ("float", [x]) => *x,
        ("floor", [x]) => x.floor(),
        ("hypot", [x, y]) => x.hypot(*y),
        ("int", [x]) => x.trunc(),
        ("log", [x]) => x.ln(),
        ("log10", [x]) => x.log10(),
        ("max", [first, rest @ ..]) => rest.iter().fold(*first, |m, v| m.max(*v)),
        ("min", [first, rest @ ..]) => rest.iter().fold(*first, |m, v| m.min(*v)),
        ("pow", [x, y]) => x.powf(*y),
        ("round", [x]) => x.round(),
        ("sin", [x]) => x.sin(),
        ("sinh", [x]) => x.sinh(),
        ("sqrt", [x]) => x.sqrt(),
        ("tan", [x]) => x.tan(),
        ("tanh", [x]) => x.tanh(),
        _ => return Err(format!("`{function}` does not take {} arguments", arguments.len())),
    })
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    raw: &'a [&'a str],
    depth: usize,
}

impl Reader<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn blanks(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    fn fault(&self, message: impl Into<String>) -> ExpressionError {
        let next = self.rest().chars().next().map_or(0, char::len_utf8);
        ExpressionError { start: self.at, end: self.at + next, message: message.into() }
    }

    fn eat(&mut self, word: &str) -> bool {
        self.blanks();
        let found = self.rest().starts_with(word);
        self.at += if found { word.len() } else { 0 };
        found
    }

    fn sum(&mut self) -> Result<Expression, ExpressionError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.fault("brackets nest too deep"));
        }
        let mut left = self.product()?;
        loop {
            let op = if self.eat("+") {
                '+'
            } else if self.eat("-") {
                '-'
            } else {
                self.depth -= 1;
                return Ok(left);
            };
            left = Expression::Binary(op, Box::new(left), Box::new(self.product()?));
        }
    }

    fn product(&mut self) -> Result<Expression, ExpressionError> {
        let mut left = self.signed()?;
        loop {
            self.blanks();
            let op = match self.rest().as_bytes() {
                [b'*', b'*', ..] => return Ok(left),
                [b'*', ..] => '*',
                [b'/', ..] => '/',
                [b'%', ..] => '%',
                _ => return Ok(left),
            };
            self.at += 1;
            left = Expression::Binary(op, Box::new(left), Box::new(self.signed()?));
        }
    }

    fn signed(&mut self) -> Result<Expression, ExpressionError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.fault("signs nest too deep"));
        }
        let result = if self.eat("-") {
            Expression::Negative(Box::new(self.signed()?))
        } else if self.eat("+") {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(result)
    }

    fn power(&mut self) -> Result<Expression, ExpressionError> {
        let base = self.atom()?;
        if self.eat("**") || self.eat("^") {
            return Ok(Expression::Binary('^', Box::new(base), Box::new(self.signed()?)));
        }
        Ok(base)
    }

    fn atom(&mut self) -> Result<Expression, ExpressionError> {
        self.blanks();
        match self.rest().chars().next() {
            None => Err(self.fault("the expression ends here; a number, a name or a bracket was expected")),
            Some('(') => self.bracket(),
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            Some(c @ ('\'' | '"')) => self.quoted(c),
            Some(c) => Err(self.fault(format!("`{c}` is not part of an expression"))),
        }
    }

    fn bracket(&mut self) -> Result<Expression, ExpressionError> {
        self.at += 1;
        let inner = self.sum()?;
        if self.eat(")") { Ok(inner) } else { Err(self.fault("a closing bracket was expected")) }
    }

    fn quoted(&mut self, quote: char) -> Result<Expression, ExpressionError> {
        let inside = &self.rest()[1..];
        let Some(length) = inside.find(quote) else { return Err(self.fault("this quote is not closed")) };
        let text = inside[..length].to_owned();
        self.at += length + 2;
        Ok(Expression::Text(text))
    }

    fn number(&mut self) -> Result<Expression, ExpressionError> {
        let bytes = self.rest().as_bytes();
        let mut length = 0;
        while let Some(c) = bytes.get(length) {
            let sign = matches!(c, b'+' | b'-') && matches!(bytes[length - 1], b'e' | b'E' | b'd' | b'D');
            if !(c.is_ascii_alphanumeric() || *c == b'.' || sign) {
                break;
            }
            length += 1;
        }
        let text = &self.rest()[..length];
        match super::number::parse_number(text) {
            Ok(value) => {
                self.at += length;
                Ok(Expression::Number(value))
            }
            Err(message) => Err(ExpressionError { start: self.at, end: self.at + length, message }),
        }
    }

    fn name(&mut self) -> Result<Expression, ExpressionError> {
        let (start, rest) = (self.at, self.rest());
        let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let name = rest[..length].to_owned();
        self.at += length;
        if !self.eat("(") {
            return Ok(Expression::Name(name));
        }
        if self.raw.contains(&name.as_str()) {
            return self.raw_argument(name);
        }
        if !FUNCTIONS.contains(&name.as_str()) {
            let message = format!("there is no function `{name}`; there are {}", FUNCTIONS.join(", "));
            return Err(ExpressionError { start, end: start + length, message });
        }
        let mut arguments = vec![self.sum()?];
        while self.eat(",") {
            arguments.push(self.sum()?);
        }
        if self.eat(")") {
            Ok(Expression::Call(name, arguments))
        } else {
            Err(self.fault("a closing bracket was expected"))
        }
    }

    fn raw_argument(&mut self, name: String) -> Result<Expression, ExpressionError> {
        let Some(length) = self.rest().find(')') else { return Err(self.fault("a closing bracket was expected")) };
        let text = self.rest()[..length].trim().to_owned();
        self.at += length + 1;
        Ok(Expression::Raw(name, text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<f64, String> {
        let name = |n: &str| if n == "n" { Ok(Value::Number(20.0)) } else { Err(format!("no {n}")) };
        let raw = |f: &str, a: &str| if (f, a) == ("final", "U2@REF") { Ok(7.0) } else { Err(a.to_owned()) };
        Expression::parse(text, &["final"]).map_err(|e| e.message)?.evaluate(&name, &raw)?.number()
    }

    #[test]
    fn arithmetic_binds_as_in_python() {
        for (text, expected) in [
            ("1+2*3", 7.0),
            ("-2**2", -4.0),
            ("2**-1", 0.5),
            ("2**3**2", 512.0),
            ("(1+n)*2", 42.0),
            ("340e6/1.d6", 340.0),
            ("7 % 4 - .5", 2.5),
            ("max(1, sqrt(16), 2)", 4.0),
            ("-1000*final(U2@REF)", -7000.0),
        ] {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn faults_are_words_not_panics() {
        for text in
            ["", "1+", "(", "1/0", "sqrt(-1)", "foo(1)", "n n", "1.o", "'a'+1", "sqrt(1,2)", "q", "é", "final(x"]
        {
            assert!(value(text).is_err(), "{text}");
        }
        assert!(value(&"(".repeat(100_000)).is_err());
        assert!(value(&"-".repeat(100_000)).is_err());
    }
}
