//! What stands in a remark: fault words, and instants.
//!
//! A text becomes words and numbers; case, accents and what lies between the words are dropped.
//! A fault word may stand for several words of the text: `DROPOUT` is found in `drop-out`, and `NG`
//! in `N.G.`, but not in `BEARING`, since it begins and ends where a word of the text does.

use crate::words::{list, word_list};
use std::ops::Range;
use std::sync::LazyLock;

/// What a text comes to.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Gist {
    /// The first fault word, as the text has it.
    pub(super) fault: Option<String>,
    /// True if an instant is named, and from when on the samples are bad if that is plain.
    pub(super) instant: Option<NamedInstant>,
    /// True if fault words stand there and each is counted as none: "skipped samples: 0".
    pub(super) denies: bool,
    /// True if the text says nothing, such as "no comments".
    pub(super) is_empty: bool,
}

/// An instant in a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum NamedInstant {
    /// The samples are bad from there on [s].
    BadFrom(f64),
    /// What it means is left to a person.
    Unclear,
}

/// Reads a text.
pub(super) fn read(text: &str) -> Gist {
    let told = RemarkTokens::of(text);
    let mut faults = told.faults();
    let denies = !faults.is_empty() && denies(text, &told, &faults);
    if denies {
        faults.clear();
    }
    let fault = faults.iter().min().and_then(|(from, to)| {
        let of_it = &told.tokens[told.within(*from, *to)];
        Some(text[of_it.first()?.at.0..of_it.last()?.at.1].to_string())
    });
    let mut faulty = vec![false; told.tokens.len()];
    for (from, to) in faults {
        faulty[told.within(from, to)].fill(true);
    }
    Gist {
        fault,
        instant: told.instant(&faulty),
        denies,
        is_empty: told.letters.is_empty() || EMPTY.contains(&told.letters),
    }
}

/// True if each fault word of a text is counted as none: in cells parted by commas and their
/// like, each from the first fault word on nothing but that word and `0`, `none` or `no` right
/// behind it, perhaps with a key before them.
fn denies(text: &str, told: &RemarkTokens, faults: &[(usize, usize)]) -> bool {
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
        let none = [Some(cell), value]
            .into_iter()
            .flatten()
            .find(|one| counts_none(one));
        let Some(none) = none else {
            return false;
        };
        let end = from + cell.len();
        cells.push(end - none.len()..end);
    }
    // A fault word may be made of the words of two cells.
    faults.iter().all(|(from, to)| {
        let tokens = &told.tokens[told.within(*from, *to)];
        let ends = tokens.first().zip(tokens.last());
        ends.is_some_and(|(first, last)| {
            let holds = |cell: &Range<usize>| cell.start <= first.at.0 && last.at.1 <= cell.end;
            cells.iter().any(holds)
        })
    })
}

/// True if a text is a fault word, or what is counted by one, and behind it `0`, `none` or `no`.
fn counts_none(text: &str) -> bool {
    let told = RemarkTokens::of(text);
    let faults = told.faults();
    let ends = faults.iter().filter(|(from, _)| *from == 0);
    // Where two words fit, the one that says more: OVERFLOW in OVERFLOWS.
    let Some((_, to)) = ends.max() else {
        return false;
    };
    let mut last = told.within(0, *to).end;
    let next = told.tokens.get(last).filter(|token| !token.parted);
    if next.is_some_and(|token| COUNTED.iter().any(|word| word == told.word(token))) {
        last += 1;
    }
    let Some(named) = last.checked_sub(1).and_then(|index| told.tokens.get(index)) else {
        return false;
    };
    let rest = text[named.at.1..].trim_matches(|c: char| c.is_whitespace() || ":=\"".contains(c));
    ["0", "none", "no"]
        .iter()
        .any(|none| rest.eq_ignore_ascii_case(none))
}

/// A fault word, as it is compared.
struct FaultWord {
    letters: String,
    /// True if letters may precede it in its word, or follow.
    anywhere: bool,
    goes_on: bool,
}

static FAULT_WORDS: LazyLock<Vec<FaultWord>> = LazyLock::new(|| {
    // An umlaut written out, and an E that begins the next word.
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

/// A list whose entries are compared as texts are.
type Folded = LazyLock<Vec<String>>;

/// Takes a list so.
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

/// Takes the E of umlauts that are written out, so that `UNGUELTIG`, `UNGÜLTIG` and `UNGULTIG` are
/// one word.
fn folded(word: &str) -> String {
    let mut before = ' ';
    let kept = |letter: &char| {
        let umlaut = *letter == 'E' && matches!(before, 'A' | 'O' | 'U');
        before = *letter;
        !umlaut
    };
    word.chars().filter(kept).collect()
}

/// Writes a character as it is compared: a capital without its accent.
fn plain(character: char, into: &mut String) {
    for capital in character.to_uppercase() {
        into.push_str(match capital {
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
            // Accents that stand for themselves.
            '\u{300}'..='\u{36F}' => "",
            other => {
                into.push(other);
                continue;
            }
        });
    }
}

/// A word or number of a text.
struct Token {
    /// Where it begins and ends among the letters.
    from: usize,
    to: usize,
    /// Where it stands in the text.
    at: (usize, usize),
    /// Of a number its digits with a decimal point; `Some(None)` if it can be read in two ways, such
    /// as 1,000.
    number: Option<Option<String>>,
    /// True if a letter or digit stands right before it.
    glued: bool,
    /// True if more than blanks stands between it and the one before.
    parted: bool,
    /// True if a part of a sentence ends before it.
    breaks: bool,
}

/// The words and numbers of a text, and their letters without anything between.
#[derive(Default)]
struct RemarkTokens {
    letters: String,
    tokens: Vec<Token>,
}

impl RemarkTokens {
    fn of(text: &str) -> Self {
        let characters: Vec<(usize, char)> = text.char_indices().collect();
        let mut told = Self::default();
        let (mut at, mut parted, mut breaks) = (0, false, false);
        while at < characters.len() {
            let start = at;
            let mut word = String::new();
            let mut number = None;
            if begins_number(&characters, at) {
                let (value, end) = read_number(&characters, at);
                number = Some(value);
                at = end;
                let digits = characters[start..at].iter().map(|(_, c)| *c);
                word.extend(digits.filter(char::is_ascii_digit));
            } else if is_letter(characters[at].1) {
                while at < characters.len()
                    && (is_letter(characters[at].1) || joins(characters[at].1))
                {
                    if !joins(characters[at].1) {
                        plain(characters[at].1, &mut word);
                    }
                    at += 1;
                }
                word = folded(&word);
            } else {
                while characters.get(at).is_some_and(|(_, c)| *c == '?') {
                    at += 1;
                }
                if at - start >= 2 {
                    word.push_str("??");
                } else {
                    at = start + 1;
                    let other = characters[start].1;
                    parted |= !other.is_whitespace();
                    breaks |= matches!(other, ';' | '.' | ',' | ':' | '!' | '?');
                    continue;
                }
            }
            // Nothing but accents.
            if word.is_empty() {
                continue;
            }
            let from = told.letters.len();
            told.letters.push_str(&word);
            let byte = |index: usize| characters.get(index).map_or(text.len(), |(byte, _)| *byte);
            let glued = start > 0 && characters[start - 1].1.is_alphanumeric();
            told.tokens.push(Token {
                from,
                to: told.letters.len(),
                at: (byte(start), byte(at)),
                number,
                glued,
                parted: std::mem::take(&mut parted),
                breaks: std::mem::take(&mut breaks),
            });
        }
        told
    }

    fn word(&self, token: &Token) -> &str {
        &self.letters[token.from..token.to]
    }

    /// Returns the words that have some of the letters.
    fn within(&self, from: usize, to: usize) -> Range<usize> {
        let first = self.tokens.partition_point(|token| token.to <= from);
        first..self.tokens.partition_point(|token| token.from < to)
    }

    /// Finds fault words: first and one past the last letter of each.
    fn faults(&self) -> Vec<(usize, usize)> {
        let ends = |at: usize| {
            self.tokens
                .binary_search_by(|token| token.to.cmp(&at))
                .is_ok()
        };
        let mut found = Vec::new();
        for word in FAULT_WORDS.iter() {
            let starts: Vec<usize> = if word.anywhere {
                let places = self.letters.match_indices(&word.letters);
                places.map(|(from, _)| from).collect()
            } else {
                let begins = |from: &usize| self.letters[*from..].starts_with(&word.letters);
                self.tokens
                    .iter()
                    .map(|token| token.from)
                    .filter(begins)
                    .collect()
            };
            let places = starts
                .into_iter()
                .map(|from| (from, from + word.letters.len()));
            found.extend(places.filter(|(_, end)| word.goes_on || ends(*end)));
        }
        found
    }

    /// Returns the instant that the text names.
    ///
    /// `faulty` tells which words are part of a fault word.
    fn instant(&self, faulty: &[bool]) -> Option<NamedInstant> {
        let all = 0..self.tokens.len();
        let instants: Vec<_> = all.filter_map(|index| self.instant_at(index)).collect();
        let plain = match instants.as_slice() {
            [] => return None,
            [(number, unit, Some(at_s))] => self.is_plain(*number, *unit, faulty).then_some(*at_s),
            _ => None,
        };
        Some(plain.map_or(NamedInstant::Unclear, NamedInstant::BadFrom))
    }

    /// Reads a number with a unit of time: its index, that of the unit's last word, and the
    /// instant [s], if there is only one way to read it.
    fn instant_at(&self, index: usize) -> Option<(usize, usize, Option<f64>)> {
        let token = &self.tokens[index];
        let number = token.number.as_ref()?;
        let next = self.tokens.get(index + 1).filter(|next| !next.parted)?;
        let unit = self.word(next);
        let (exponent, last) = match exponent(unit) {
            Some(exponent) => (exponent, index + 1),
            // "10 m sec", and what was cut there.
            None => {
                let after = self.tokens.get(index + 2).filter(|after| !after.parted)?;
                (exponent(&format!("{unit}{}", self.word(after)))?, index + 2)
            }
        };
        // A12S is the number of a sensor.
        if token.glued && unit == "S" {
            return None;
        }
        // The exponent goes in before the number is read, so that 64.6 ms are 0.0646 s to the bit.
        let seconds = |digits: &String| format!("{digits}e{exponent}").parse().ok();
        let instant = number.as_ref().and_then(seconds);
        Some((index, last, instant))
    }

    /// True if the samples are bad from the instant on: by "BAD AFTER …" with nothing else
    /// in the text but faults and words that change nothing.
    fn is_plain(&self, number: usize, unit: usize, faulty: &[bool]) -> bool {
        let mut before = self.tokens[..=number].iter().skip(1);
        let in_one_breath = before.all(|token| !token.breaks);
        let numbers = self.tokens.iter().filter(|token| token.number.is_some());
        if number == 0 || !in_one_breath || numbers.count() > 1 {
            return false;
        }
        let last = number - 1;
        let is_one_of = |index: usize, list: &[String]| {
            let word = self.word(&self.tokens[index]);
            list.iter().any(|known| known == word)
        };
        let known = |index: usize| faulty[index] || is_one_of(index, &BESIDE);
        is_one_of(last, &AFTER)
            && faulty[..last].contains(&true)
            && (0..last).chain(unit + 1..self.tokens.len()).all(known)
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

/// True if a character stands in a word and is none of its letters: DON'T.
fn joins(character: char) -> bool {
    matches!(character, '\'' | '\u{2019}' | '\u{AD}')
}

fn begins_number(characters: &[(usize, char)], at: usize) -> bool {
    let character = |index: usize| characters.get(index).map(|(_, c)| *c);
    let digit = |index: usize| character(index).is_some_and(|c| c.is_ascii_digit());
    let free = at == 0 || !characters[at - 1].1.is_alphanumeric();
    let marked = |index: usize| {
        digit(index) || (matches!(character(index), Some('.' | ',')) && digit(index + 1))
    };
    match characters[at].1 {
        '0'..='9' => true,
        '.' | ',' => digit(at + 1) && free,
        '-' | '+' | '\u{2212}' => free && marked(at + 1),
        _ => false,
    }
}

/// Reads the number that begins at a place, and returns it with the place after it.
fn read_number(characters: &[(usize, char)], start: usize) -> (Option<String>, usize) {
    let character = |index: usize| characters.get(index).map(|(_, c)| *c);
    let is_digit = |index: usize| character(index).is_some_and(|c| c.is_ascii_digit());
    let mut digits = String::new();
    let mut at = start;
    if let Some(sign @ ('-' | '+' | '\u{2212}')) = character(at) {
        digits.push(if sign == '+' { '+' } else { '-' });
        at += 1;
    }
    let mut mark = None;
    let mut marks = 0;
    while let Some(next) = character(at) {
        match next {
            '0'..='9' => digits.push(next),
            '.' | ',' if is_digit(at + 1) => {
                marks += 1;
                mark = Some((at, next));
                digits.push('.');
            }
            _ => break,
        }
        at += 1;
    }
    // 1,000 may be a thousand.
    let thousands = mark.is_some_and(|(mark, sign)| sign == ',' && at - mark == 4);
    ((marks <= 1 && !thousands).then_some(digits), at)
}
