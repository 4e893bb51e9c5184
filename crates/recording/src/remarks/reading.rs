//! The content of a remark: fault words, and instants.
//!
//! A text becomes words and numbers; case, accents and the marks between words are dropped. A fault word
//! may match several words of the text: `DROPOUT` is found in `drop-out`, and `NG` in `N.G.`, but not in
//! `BEARING`, since it must begin and end where a word of the text does.

use crate::words::{list, word_list};
use std::ops::Range;
use std::sync::LazyLock;

/// Result of reading a text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RemarkReading {
    /// The first fault word, as the text has it.
    pub(super) fault: Option<String>,
    /// The instant that is named, if any.
    pub(super) instant: Option<NamedInstant>,
    /// True if there are fault words and each is counted as none: "skipped samples: 0".
    pub(super) denies: bool,
    /// True if the text has no content, such as "no comments".
    pub(super) is_empty: bool,
}

/// An instant in a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum NamedInstant {
    /// The samples are bad from there on [s].
    BadFrom(f64),
    /// Its meaning is left to a person.
    Unclear,
}

/// Reads a text.
pub(super) fn read(text: &str) -> RemarkReading {
    let remark = RemarkTokens::of(text);
    let mut faults = remark.faults();
    let denies = !faults.is_empty() && denies(text, &remark, &faults);
    if denies {
        faults.clear();
    }
    let fault = faults.iter().min().and_then(|fault| {
        let fault_tokens = &remark.tokens[remark.within(*fault)];
        let bytes = fault_tokens.first()?.bytes.start..fault_tokens.last()?.bytes.end;
        Some(text[bytes].to_string())
    });
    let mut faulty = vec![false; remark.tokens.len()];
    for fault in faults {
        faulty[remark.within(fault)].fill(true);
    }
    RemarkReading {
        fault,
        instant: remark.instant(&faulty),
        denies,
        is_empty: remark.letters.is_empty() || EMPTY.contains(&remark.letters),
    }
}

/// True if each fault word of a text is counted as none: in each cell between commas and the like, from
/// the first fault word on, there is only that word and `0`, `none` or `no` right after it, perhaps with
/// a key before them.
fn denies(text: &str, remark: &RemarkTokens, faults: &[Letters]) -> bool {
    let mut cells: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    for cell in text.split_inclusive([',', ';', '\t', '|']) {
        let from = start;
        start += cell.len();
        if cells.is_empty() && RemarkTokens::of(cell).faults().is_empty() {
            continue;
        }
        let cell = cell.trim_end_matches([',', ';', '\t', '|']);
        if cell.trim().is_empty() {
            continue;
        }
        let value = cell.split_once([':', '=']).map(|(_, value)| value);
        let none_count = [Some(cell), value]
            .into_iter()
            .flatten()
            .find(|text| counts_none(text));
        let Some(none_count) = none_count else {
            return false;
        };
        let end = from + cell.len();
        cells.push(end - none_count.len()..end);
    }
    // A fault word may span the words of two cells.
    faults.iter().all(|fault| {
        let tokens = &remark.tokens[remark.within(*fault)];
        let ends = tokens.first().zip(tokens.last());
        ends.is_some_and(|(first, last)| {
            let holds =
                |cell: &Range<usize>| cell.start <= first.bytes.start && last.bytes.end <= cell.end;
            cells.iter().any(holds)
        })
    })
}

/// True if a text is a fault word, or a thing that it counts, and `0`, `none` or `no` after it.
fn counts_none(text: &str) -> bool {
    let remark = RemarkTokens::of(text);
    let faults = remark.faults();
    let at_the_start = faults.iter().filter(|fault| fault.start == 0);
    // Where two words match, the longer counts: OVERFLOWS over OVERFLOW.
    let Some(fault) = at_the_start.max() else {
        return false;
    };
    let mut last = remark.within(*fault).end;
    let next = remark.tokens.get(last).filter(|token| !token.parted);
    if next.is_some_and(|token| COUNTED.iter().any(|word| word == remark.word(token))) {
        last += 1;
    }
    let Some(last_token) = last
        .checked_sub(1)
        .and_then(|index| remark.tokens.get(index))
    else {
        return false;
    };
    let tail = text[last_token.bytes.end..]
        .trim_matches(|c: char| c.is_whitespace() || ":=\"".contains(c));
    ["0", "none", "no"]
        .iter()
        .any(|word| tail.eq_ignore_ascii_case(word))
}

/// A fault word, in the form in which it is compared.
struct FaultWord {
    letters: String,
    /// True if letters may precede it in its word.
    anywhere: bool,
    goes_on: bool,
}

static FAULT_WORDS: LazyLock<Vec<FaultWord>> = LazyLock::new(|| {
    // An umlaut may be written as two letters, or the E may begin the next word.
    let both = |entry: &'static str| {
        let word = entry.trim_matches('*');
        [folded(word), word.to_string()].map(|letters| FaultWord {
            letters,
            anywhere: entry.starts_with('*'),
            goes_on: entry.ends_with('*'),
        })
    };
    let entries = list(word_list!(@text "fault-words"));
    entries.into_iter().flat_map(both).collect()
});

/// A list whose entries are folded as texts are.
type Folded = LazyLock<Vec<String>>;

/// Builds such a list.
macro_rules! folded_list {
    ($name:literal) => {
        LazyLock::new(|| {
            let entries = list(word_list!(@text $name));
            entries.into_iter().map(folded).collect()
        })
    };
}

// The head of each list explains it.
static EMPTY: Folded = folded_list!("remark-empty");
static COUNTED: Folded = folded_list!("fault-counted");
static AFTER: Folded = folded_list!("instant-after");
static BESIDE: Folded = folded_list!("instant-beside");

/// Removes the E of umlauts that are written as two letters, so that `UNGUELTIG`, `UNGÜLTIG` and
/// `UNGULTIG` are one word.
fn folded(word: &str) -> String {
    let mut previous = ' ';
    let kept = |letter: &char| {
        let umlaut = *letter == 'E' && matches!(previous, 'A' | 'O' | 'U');
        previous = *letter;
        !umlaut
    };
    word.chars().filter(kept).collect()
}

/// Writes a character in the form in which it is compared: a capital without its accent.
fn plain(character: char, output: &mut String) {
    for capital in character.to_uppercase() {
        output.push_str(match capital {
            'À'..='Å' | 'Ā' | 'Ă' | 'Ą' => "A",
            'Æ' => "AE",
            'Ç' | 'Ć' | 'Č' => "C",
            'È'..='Ë' | 'Ē' | 'Ę' | 'Ě' => "E",
            'Ì'..='Ï' | 'Ī' => "I",
            'Ñ' | 'Ń' => "N",
            'Ò'..='Ö' | 'Ø' | 'Ō' | 'Ő' => "O",
            'Œ' => "OE",
            'Ù'..='Ü' | 'Ū' | 'Ů' | 'Ű' => "U",
            'Ý' | 'Ÿ' => "Y",
            'Š' | 'Ś' => "S",
            'Ž' | 'Ź' | 'Ż' => "Z",
            // Combining accents.
            '\u{300}'..='\u{36F}' => "",
            letter => {
                output.push(letter);
                continue;
            }
        });
    }
}

/// A range of the letters of a text, first and one past the last.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Letters {
    start: usize,
    end: usize,
}

/// A word or number of a text.
struct Token {
    letters: Letters,
    /// Bytes in the text.
    bytes: Range<usize>,
    /// Digits of a number with a decimal point; `Some(None)` if it can be read in two ways, such as 1,000.
    number: Option<Option<String>>,
    /// True if a letter or digit is right before it.
    glued: bool,
    /// True if there is more than blanks between it and the one before.
    parted: bool,
    /// True if a part of a sentence ends before it.
    breaks: bool,
}

/// A number with a unit of time.
struct TokenInstant {
    /// Index of the number's token.
    number: usize,
    /// Index of the last token of the unit.
    unit: usize,
    /// The instant [s]; `None` if the number can be read in two ways.
    at_s: Option<f64>,
}

/// The words and numbers of a text, and their letters in a row.
#[derive(Default)]
struct RemarkTokens {
    letters: String,
    tokens: Vec<Token>,
}

impl RemarkTokens {
    fn of(text: &str) -> Self {
        let characters: Vec<(usize, char)> = text.char_indices().collect();
        let mut remark = Self::default();
        let (mut index, mut parted, mut breaks) = (0, false, false);
        while index < characters.len() {
            let start = index;
            let mut word = String::new();
            let mut number = None;
            if begins_number(&characters, index) {
                let (value, end) = read_number(&characters, index);
                number = Some(value);
                index = end;
                let digits = characters[start..index].iter().map(|(_, c)| *c);
                word.extend(digits.filter(char::is_ascii_digit));
            } else if is_letter(characters[index].1) {
                while index < characters.len()
                    && (is_letter(characters[index].1) || joins(characters[index].1))
                {
                    if !joins(characters[index].1) {
                        plain(characters[index].1, &mut word);
                    }
                    index += 1;
                }
                word = folded(&word);
            } else {
                while characters.get(index).is_some_and(|(_, c)| *c == '?') {
                    index += 1;
                }
                if index - start >= 2 {
                    word.push_str("??");
                } else {
                    index = start + 1;
                    let character = characters[start].1;
                    parted |= !character.is_whitespace();
                    breaks |= matches!(character, ';' | '.' | ',' | ':' | '!' | '?');
                    continue;
                }
            }
            // A word of accents alone has no letter.
            if word.is_empty() {
                continue;
            }
            let start_letter = remark.letters.len();
            remark.letters.push_str(&word);
            let byte = |position: usize| {
                characters
                    .get(position)
                    .map_or(text.len(), |(byte, _)| *byte)
            };
            let glued = start > 0 && characters[start - 1].1.is_alphanumeric();
            remark.tokens.push(Token {
                letters: Letters {
                    start: start_letter,
                    end: remark.letters.len(),
                },
                bytes: byte(start)..byte(index),
                number,
                glued,
                parted: std::mem::take(&mut parted),
                breaks: std::mem::take(&mut breaks),
            });
        }
        remark
    }

    fn word(&self, token: &Token) -> &str {
        &self.letters[token.letters.start..token.letters.end]
    }

    /// Returns the tokens that have some of the letters.
    fn within(&self, letters: Letters) -> Range<usize> {
        let is_before = |token: &Token| token.letters.end <= letters.start;
        let begins_before_the_end = |token: &Token| token.letters.start < letters.end;
        let first = self.tokens.partition_point(is_before);
        first..self.tokens.partition_point(begins_before_the_end)
    }

    /// Finds the letters of each fault word.
    fn faults(&self) -> Vec<Letters> {
        let ends_a_token = |end: usize| {
            self.tokens
                .binary_search_by(|token| token.letters.end.cmp(&end))
                .is_ok()
        };
        let mut faults = Vec::new();
        for word in FAULT_WORDS.iter() {
            let starts: Vec<usize> = if word.anywhere {
                let matches = self.letters.match_indices(&word.letters);
                matches.map(|(start, _)| start).collect()
            } else {
                let begins = |start: &usize| self.letters[*start..].starts_with(&word.letters);
                self.tokens
                    .iter()
                    .map(|token| token.letters.start)
                    .filter(begins)
                    .collect()
            };
            let matches = starts.into_iter().map(|start| Letters {
                start,
                end: start + word.letters.len(),
            });
            faults.extend(matches.filter(|fault| word.goes_on || ends_a_token(fault.end)));
        }
        faults
    }

    /// Returns the instant that the text names. `faulty` is true for tokens of a fault word.
    fn instant(&self, faulty: &[bool]) -> Option<NamedInstant> {
        let indices = 0..self.tokens.len();
        let instants: Vec<_> = indices.filter_map(|index| self.instant_at(index)).collect();
        let plain = match instants.as_slice() {
            [] => return None,
            [instant] => instant.at_s.filter(|_| self.is_plain(instant, faulty)),
            _ => None,
        };
        Some(plain.map_or(NamedInstant::Unclear, NamedInstant::BadFrom))
    }

    /// Reads a number with a unit of time; its instant is `None` if it can be read in two ways.
    fn instant_at(&self, index: usize) -> Option<TokenInstant> {
        let token = &self.tokens[index];
        let number = token.number.as_ref()?;
        let next = self.tokens.get(index + 1).filter(|next| !next.parted)?;
        let unit = self.word(next);
        let (exponent, last) = match exponent(unit) {
            Some(exponent) => (exponent, index + 1),
            // "10 m sec", or a unit that was cut there.
            None => {
                let after = self.tokens.get(index + 2).filter(|after| !after.parted)?;
                (exponent(&format!("{unit}{}", self.word(after)))?, index + 2)
            }
        };
        // A12S is the number of a sensor.
        if token.glued && unit == "S" {
            return None;
        }
        // The exponent is appended before the number is parsed, so that 64.6 ms are 0.0646 s to the bit.
        let seconds = |digits: &String| format!("{digits}e{exponent}").parse().ok();
        Some(TokenInstant {
            number: index,
            unit: last,
            at_s: number.as_ref().and_then(seconds),
        })
    }

    /// True if the samples are bad from the instant on: by "BAD AFTER …" with nothing else in the text but
    /// faults and words that change nothing.
    fn is_plain(&self, instant: &TokenInstant, faulty: &[bool]) -> bool {
        let (number, unit) = (instant.number, instant.unit);
        let mut tokens = self.tokens[..=number].iter().skip(1);
        let in_one_breath = tokens.all(|token| !token.breaks);
        let numbers = self.tokens.iter().filter(|token| token.number.is_some());
        if number == 0 || !in_one_breath || numbers.count() > 1 {
            return false;
        }
        let last = number - 1;
        let is_one_of = |index: usize, list: &[String]| {
            let word = self.word(&self.tokens[index]);
            list.iter().any(|entry| entry == word)
        };
        let is_known = |index: usize| faulty[index] || is_one_of(index, &BESIDE);
        is_one_of(last, &AFTER)
            && faulty[..last].contains(&true)
            && (0..last).chain(unit + 1..self.tokens.len()).all(is_known)
    }
}

/// Returns the power of ten of a unit of time in seconds.
fn exponent(unit: &str) -> Option<i32> {
    match unit {
        "S" => Some(0),
        "MS" => Some(-3),
        "US" => Some(-6),
        // SECONDS, SEKUNDEN, SEGUNDOS; NHTSA's own files hold MILLSECONDS.
        _ => ["SEC", "SEK", "SEG"]
            .iter()
            .find_map(|stem| match unit.split_once(stem)?.0 {
                "" => Some(0),
                "M" => Some(-3),
                "U" => Some(-6),
                long if long.starts_with("MIL") => Some(-3),
                long if long.starts_with("MIC") || long.starts_with("MIK") => Some(-6),
                _ => None,
            }),
    }
}

/// True if a character is part of a word.
fn is_letter(character: char) -> bool {
    character.is_alphanumeric() && !character.is_ascii_digit()
        || ('\u{300}'..='\u{36F}').contains(&character)
}

/// True if a character is in a word without being one of its letters: DON'T.
fn joins(character: char) -> bool {
    matches!(character, '\'' | '\u{2019}' | '\u{AD}')
}

fn begins_number(characters: &[(usize, char)], start: usize) -> bool {
    let character = |index: usize| characters.get(index).map(|(_, c)| *c);
    let digit = |index: usize| character(index).is_some_and(|c| c.is_ascii_digit());
    let is_free = start == 0 || !characters[start - 1].1.is_alphanumeric();
    let marked = |index: usize| {
        digit(index) || (matches!(character(index), Some('.' | ',')) && digit(index + 1))
    };
    match characters[start].1 {
        '0'..='9' => true,
        '.' | ',' => digit(start + 1) && is_free,
        '-' | '+' | '\u{2212}' => is_free && marked(start + 1),
        _ => false,
    }
}

/// Reads the number that begins at `start`, and returns it with the position after it.
fn read_number(characters: &[(usize, char)], start: usize) -> (Option<String>, usize) {
    let character = |index: usize| characters.get(index).map(|(_, c)| *c);
    let is_digit = |index: usize| character(index).is_some_and(|c| c.is_ascii_digit());
    let mut digits = String::new();
    let mut position = start;
    if let Some(sign @ ('-' | '+' | '\u{2212}')) = character(position) {
        digits.push(if sign == '+' { '+' } else { '-' });
        position += 1;
    }
    let mut mark = None;
    let mut marks = 0;
    while let Some(next) = character(position) {
        match next {
            '0'..='9' => digits.push(next),
            '.' | ',' if is_digit(position + 1) => {
                marks += 1;
                mark = Some((position, next));
                digits.push('.');
            }
            _ => break,
        }
        position += 1;
    }
    // 1,000 may be a thousand.
    let thousands = mark.is_some_and(|(mark, sign)| sign == ',' && position - mark == 4);
    ((marks <= 1 && !thousands).then_some(digits), position)
}
