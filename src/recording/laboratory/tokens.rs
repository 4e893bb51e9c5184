//! Words, numbers and instants of a comment.

use super::words::STRETCH;

/// A part of a comment.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token {
    /// A word in capitals, umlauts written out.
    Word(String),
    /// A number: digits with a decimal point, and power of ten; `None` if it can be read in two
    /// ways, such as 1,000.
    Number(Option<(String, i32)>),
    /// The end of a sentence or a part of one.
    Break,
}

impl Token {
    pub(super) fn is_one_of(&self, list: &[&str]) -> bool {
        match self {
            Self::Word(word) => list.contains(&word.as_str()),
            Self::Number(_) | Self::Break => false,
        }
    }

    /// Tells whether this is one of the words, misspelt: a letter too many, too few or wrong, or
    /// two that changed places; of long words two such slips. The first letter stays, for
    /// "VALIDATED" is not "INVALIDATED".
    pub(super) fn resembles(&self, list: &[&str]) -> bool {
        let Self::Word(word) = self else { return false };
        list.iter().any(|known| {
            word.len().abs_diff(known.len()) <= 2
                && word.as_bytes().first() == known.as_bytes().first()
                && strsim::osa_distance(word, known) <= if known.len() > 10 { 2 } else { 1 }
        })
    }

    /// Returns the power of ten of a unit of time in seconds.
    pub(super) fn exponent(&self) -> Option<i32> {
        let Self::Word(word) = self else { return None };
        match word.as_str() {
            "S" | "SEC" | "SECS" | "SECOND" | "SECONDS" | "SEK" | "SEKUNDE" | "SEKUNDEN" => Some(0),
            "MS" | "MSEC" | "MSECS" | "MSECOND" | "MSECONDS" | "MSEK" => Some(-3),
            "US" | "USEC" | "USECS" => Some(-6),
            // NHTSA's own files hold "MILLSECONDS".
            other if other.contains("SEC") || other.contains("SEK") => {
                if other.starts_with("MIL") {
                    Some(-3)
                } else if other.starts_with("MICRO") || other.starts_with("MIKRO") {
                    Some(-6)
                } else {
                    None
                }
            }
            _ => None,
        }
    }

    /// Returns the number in a unit that is `exponent` powers of ten of a second [s].
    pub(super) fn instant(&self, exponent: i32) -> Option<f64> {
        // The exponent goes in before the number is read, so that 64.6 ms are 0.0646 s to the
        // bit.
        let Self::Number(Some((digits, own))) = self else {
            return None;
        };
        format!("{digits}e{}", own + exponent)
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())
    }

    pub(super) fn shown(&self) -> String {
        match self {
            Self::Word(word) => word.clone(),
            Self::Number(Some((digits, _))) => digits.clone(),
            Self::Number(None) => "?".into(),
            Self::Break => String::new(),
        }
    }
}

/// Splits a comment; a number and a unit written together come apart.
pub(super) fn tokens(comment: &str) -> Vec<Token> {
    let characters: Vec<char> = capitals(comment);
    let mut found: Vec<Token> = Vec::new();
    let mut at = 0;
    while at < characters.len() {
        let character = characters[at];
        let next = characters.get(at + 1).copied();
        let digit_next = next.is_some_and(|c| c.is_ascii_digit());
        let free = at == 0 || !characters[at - 1].is_alphanumeric();
        let signed = matches!(character, '-' | '+')
            && free
            && (digit_next
                || (matches!(next, Some('.' | ','))
                    && characters.get(at + 2).is_some_and(char::is_ascii_digit)));
        let begins_number =
            character.is_ascii_digit() || (matches!(character, '.' | ',') && digit_next) || signed;
        if begins_number {
            let (number, end) = number(&characters, at);
            found.push(number);
            at = end;
        } else if character.is_alphanumeric() {
            let start = at;
            while at < characters.len() && characters[at].is_alphanumeric() {
                at += 1;
            }
            found.push(Token::Word(characters[start..at].iter().collect()));
        } else {
            let dash = character == '-' && free && !next.is_some_and(char::is_alphanumeric);
            let ends = matches!(character, ';' | '.' | ',' | ':' | '!' | '?') || dash;
            if ends && found.last().is_some_and(|last| *last != Token::Break) {
                found.push(Token::Break);
            }
            at += 1;
        }
    }
    if found.last() == Some(&Token::Break) {
        found.pop();
    }
    found
}

/// Returns the characters in capitals, umlauts written out, without apostrophes.
fn capitals(comment: &str) -> Vec<char> {
    let mut found = Vec::with_capacity(comment.len());
    for character in comment.chars().flat_map(char::to_uppercase) {
        match character {
            'Ä' => found.extend(['A', 'E']),
            'Ö' => found.extend(['O', 'E']),
            'Ü' => found.extend(['U', 'E']),
            '\'' | '\u{2019}' => {}
            '\u{2013}' | '\u{2014}' | '\u{2212}' => found.push('-'),
            other => found.push(other),
        }
    }
    found
}

/// Reads the number that begins at a place, and returns it with the place after it.
fn number(characters: &[char], start: usize) -> (Token, usize) {
    let mut digits = String::new();
    let mut at = start;
    if matches!(characters[at], '-' | '+') {
        digits.push(characters[at]);
        at += 1;
    }
    let is_digit = |at: usize| characters.get(at).is_some_and(char::is_ascii_digit);
    let (mut whole, mut decimals, mut marks, mut comma) = (0, 0, 0, false);
    let mut leading_zero = false;
    loop {
        match characters.get(at) {
            Some(digit) if digit.is_ascii_digit() => {
                if marks == 0 {
                    leading_zero |= whole == 0 && *digit == '0';
                    whole += 1;
                } else {
                    decimals += 1;
                }
                digits.push(*digit);
            }
            Some(mark @ ('.' | ',')) if is_digit(at + 1) => {
                marks += 1;
                comma |= *mark == ',';
                digits.push('.');
            }
            _ => break,
        }
        at += 1;
    }
    // 1.0E-2, but not 10 EVENTS.
    let mut exponent = 0_i32;
    if characters.get(at) == Some(&'E') {
        let signed = usize::from(matches!(characters.get(at + 1), Some('-' | '+')));
        if is_digit(at + 1 + signed) {
            let first = at + 1;
            at = first + signed;
            while is_digit(at) {
                at += 1;
            }
            let text: String = characters[first..at].iter().collect();
            exponent = text.parse::<i32>().unwrap_or(0).clamp(-400, 400);
        }
    }
    let thousands = comma && decimals == 3 && (1..=3).contains(&whole) && !leading_zero;
    let readable = marks <= 1 && !thousands;
    (Token::Number(readable.then_some((digits, exponent))), at)
}

/// Finds numbers with a unit of time: index of the number among the tokens, and instant [s];
/// `None` where it can be read in two ways.
pub(super) fn instants(tokens: &[Token]) -> Vec<(usize, Option<f64>)> {
    let is_number = |index: usize| matches!(tokens[index], Token::Number(_));
    let mut found = Vec::new();
    for index in 0..tokens.len().saturating_sub(1) {
        let Some(exponent) = tokens[index + 1].exponent() else {
            continue;
        };
        if !is_number(index) {
            continue;
        }
        let instant = tokens[index].instant(exponent);
        found.push((index, instant));
        // "between 60 and 65 ms", "60 to 65 ms", "60-65 ms"
        let earlier = if index >= 1 && is_number(index - 1) {
            Some(index - 1)
        } else if index >= 2 && tokens[index - 1].is_one_of(&STRETCH) && is_number(index - 2) {
            Some(index - 2)
        } else {
            None
        };
        if let Some(earlier) = earlier {
            let start = tokens[earlier].instant(exponent);
            // 10-2 s is no stretch.
            found.push((
                index,
                start.filter(|start| instant.is_some_and(|end| *start <= end)),
            ));
        }
    }
    found
}
