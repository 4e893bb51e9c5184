//! The cases of text files, which are data: `tests/data/golden/TABLE.toml`, as its README says. A file
//! that is broken ends the test with its place and the reason.

use super::built;
use super::case::{Case, Read};
use super::template::expand;
use latchgate_test_support::{data, gzip_of, tar_of, zip_of};
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::{Spanned, Table, Value};

/// Reads the cases of a table.
pub(super) fn cases(table: &str) -> Vec<Case> {
    let path = data(&format!("golden/{table}.toml"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{table}: {error}"));
    parsed(table, &text).unwrap_or_else(|reason| panic!("{}: {reason}", path.display()))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sheet {
    default: Default,
    /// Texts that cases share.
    #[serde(default)]
    text: BTreeMap<String, String>,
    #[serde(rename = "case")]
    cases: Vec<Spanned<Table>>,
}

/// What holds where a case does not say otherwise.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Default {
    file: Option<String>,
    text: Option<String>,
    channel: String,
    unit: String,
    values: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    file: Option<String>,
    text: Option<String>,
    of: Option<String>,
    #[serde(default)]
    edits: Vec<(String, String)>,
    #[serde(default)]
    everywhere: Vec<(String, String)>,
    #[serde(default)]
    encoding: Encoding,
    #[serde(default)]
    zeros: usize,
    /// A change of the bytes by Rust, by its name.
    altered: Option<String>,
    /// How many bytes stay.
    cut: Option<usize>,
    /// True for a file that Rust writes.
    #[serde(default)]
    built: bool,
    pack: Option<Pack>,
    #[serde(default)]
    inside: Vec<(String, Value)>,
    card: Option<String>,
    #[serde(default)]
    beside: BTreeMap<String, Value>,
    opened: Option<String>,
    opens: Option<String>,
    options: Option<Words>,
    exit: Option<i32>,
    refused: Option<Vec<String>>,
    unusable: Option<Vec<String>>,
    #[serde(default)]
    says: Vec<String>,
    #[serde(default)]
    finds: Vec<String>,
    channel: Option<String>,
    unit: Option<String>,
    rate: Option<f64>,
    start: Option<f64>,
    samples: Option<usize>,
    values: Option<String>,
    scale: Option<f64>,
}

#[derive(Deserialize, Clone, Copy, std::default::Default)]
enum Encoding {
    #[default]
    #[serde(rename = "utf-8")]
    Utf8,
    #[serde(rename = "latin-1")]
    Latin1,
    #[serde(rename = "utf-16le")]
    Utf16Le,
    #[serde(rename = "utf-16be")]
    Utf16Be,
}

#[derive(Deserialize, Clone, Copy)]
enum Pack {
    #[serde(rename = "zip")]
    Zip,
    #[serde(rename = "tar")]
    Tar,
    #[serde(rename = "tar.gz")]
    TarGz,
}

/// The text of a file and how it is written.
#[derive(Deserialize, std::default::Default)]
#[serde(deny_unknown_fields)]
struct Spelling {
    text: Option<String>,
    of: Option<String>,
    #[serde(default)]
    edits: Vec<(String, String)>,
    #[serde(default)]
    everywhere: Vec<(String, String)>,
    #[serde(default)]
    encoding: Encoding,
}

/// Options with blanks between them, or one by one.
#[derive(Deserialize)]
#[serde(untagged)]
enum Words {
    Line(String),
    List(Vec<String>),
}

fn parsed(table: &str, text: &str) -> Result<Vec<Case>, String> {
    let sheet: Sheet = toml::from_str(text).map_err(|error| error.to_string())?;
    let mut cases = Vec::new();
    for case in &sheet.cases {
        let line = text[..case.span().start].matches('\n').count() + 1;
        let place = |reason| format!("line {line}: {reason}");
        for entry in entries(case.get_ref()).map_err(place)? {
            let name = entry
                .get("name")
                .and_then(Value::as_str)
                .unwrap_or_default();
            let name = format!("`{name}`");
            let case = Entry::deserialize(Value::Table(entry))
                .map_err(|error| error.to_string().trim().to_string())
                .and_then(|entry| sheet.case(table, entry))
                .map_err(|reason| place(format!("case {name}: {reason}")))?;
            cases.push(case);
        }
    }
    Ok(cases)
}

/// The cases that one entry stands for: of each item all kinds, `$1`, `$2` and so on being the item's words
/// and `$#` its index.
fn entries(case: &Table) -> Result<Vec<Table>, String> {
    let mut common = case.clone();
    let array = |value, key: &str| match value {
        None => Ok(None),
        Some(Value::Array(list)) if !list.is_empty() => Ok(Some(list)),
        Some(_) => Err(format!("`{key}` is no list, or empty")),
    };
    let items = array(common.remove("each"), "each")?;
    let kinds = array(common.remove("kind"), "kind")?;
    let kinds = kinds.unwrap_or_else(|| vec![Value::Table(Table::new())]);
    let mut all = Vec::new();
    for (index, item) in items
        .as_ref()
        .map_or(vec![None], |items| items.iter().map(Some).collect())
        .into_iter()
        .enumerate()
    {
        for kind in &kinds {
            let mut entry = common.clone();
            let kind = kind.as_table().ok_or("a kind is a table")?;
            entry.extend(kind.clone());
            if let Some(item) = item {
                let words = match item {
                    Value::Array(words) => words.clone(),
                    word => vec![word.clone()],
                };
                let words: Option<Vec<&str>> = words.iter().map(Value::as_str).collect();
                entry = filled(&entry, index, &words.ok_or("an item is no text")?)?;
            }
            all.push(entry);
        }
    }
    Ok(all)
}

fn filled(entry: &Table, index: usize, words: &[&str]) -> Result<Table, String> {
    let pairs = entry.iter();
    pairs
        .map(|(key, value)| {
            Ok((
                filled_text(key, index, words)?,
                filled_value(value, index, words)?,
            ))
        })
        .collect()
}

fn filled_value(value: &Value, index: usize, words: &[&str]) -> Result<Value, String> {
    Ok(match value {
        Value::String(text) => Value::String(filled_text(text, index, words)?),
        Value::Array(list) => Value::Array(
            list.iter()
                .map(|value| filled_value(value, index, words))
                .collect::<Result<_, _>>()?,
        ),
        Value::Table(table) => Value::Table(filled(table, index, words)?),
        other => other.clone(),
    })
}

fn filled_text(text: &str, index: usize, words: &[&str]) -> Result<String, String> {
    let mut pieces = text.split('$');
    let mut filled = pieces.next().unwrap_or_default().to_string();
    for piece in pieces {
        let mark = piece.chars().next();
        match mark {
            Some('#') => filled += &index.to_string(),
            _ => {
                let digit = mark.and_then(|mark| mark.to_digit(10)).unwrap_or(0) as usize;
                let word = words.get(digit.wrapping_sub(1));
                filled += word.ok_or_else(|| format!("`${piece}` is no word of an item"))?;
            }
        }
        filled += &piece[1..];
    }
    Ok(filled)
}

impl Sheet {
    fn case(&self, table: &str, mut entry: Entry) -> Result<Case, String> {
        let file = entry.file.take().or_else(|| self.default.file.clone());
        let file = file.unwrap_or_else(|| entry.name.clone());
        let mut files = vec![(file.clone(), self.bytes(table, &mut entry)?)];
        if let Some(card) = &entry.card {
            files.push((format!("{file}.toml"), card.clone().into_bytes()));
        }
        for (name, content) in &entry.beside {
            let bytes = self.content(content);
            files.push((
                name.clone(),
                bytes.map_err(|reason| format!("{name}: {reason}"))?,
            ));
        }
        let opens = entry.opens.take().unwrap_or_else(|| "negative".into());
        let mut options = vec!["--opens-when".to_string(), opens];
        match &entry.options {
            None => {}
            Some(Words::Line(line)) => options.extend(line.split(' ').map(String::from)),
            Some(Words::List(list)) => options.extend(list.iter().cloned()),
        }
        let mut findings = entry.finds.clone();
        let (exit, says) = match (entry.exit, &entry.refused, &entry.unusable) {
            (Some(exit @ (0 | 1 | 3)), None, None) => (exit, &entry.says),
            (None, Some(says), None) => {
                findings.push("blocking input-refused".into());
                (4, says)
            }
            (None, None, Some(says)) => {
                if !findings
                    .iter()
                    .any(|finding| finding.starts_with("blocking "))
                {
                    return Err("it is unusable, and nothing that it finds blocks".into());
                }
                (4, says)
            }
            (None, None, None) => {
                return Err("it expects nothing: `exit`, `refused` or `unusable`".into());
            }
            _ => return Err("one of `exit` (0, 1 or 3), `refused` and `unusable`".into()),
        };
        if entry.exit.is_none() && (says.is_empty() || !entry.says.is_empty()) {
            return Err("words of the message stand with `refused` or `unusable`".into());
        }
        let read = match entry.refused {
            None => Some(self.read(table, &entry)?),
            Some(_) if entry.reads() => return Err("it is refused, and yet read".into()),
            Some(_) => None,
        };
        Ok(Case {
            opened: entry.opened.clone().unwrap_or(file),
            says: says.clone(),
            name: entry.name,
            files,
            options,
            exit,
            read,
            findings,
        })
    }

    /// The bytes of the first file.
    fn bytes(&self, table: &str, entry: &mut Entry) -> Result<Vec<u8>, String> {
        let mut bytes = self.whole(table, entry)?;
        bytes.resize(bytes.len() + entry.zeros, 0);
        if let Some(alteration) = &entry.altered {
            bytes = built::altered(alteration, &bytes).ok_or("no such alteration")?;
        }
        match entry.cut {
            Some(cut) if cut >= bytes.len() => return Err("`cut` leaves all bytes".into()),
            Some(cut) => bytes.truncate(cut),
            None => {}
        }
        Ok(bytes)
    }

    fn whole(&self, table: &str, entry: &mut Entry) -> Result<Vec<u8>, String> {
        let spelled = entry.text.is_some() || entry.of.is_some() || !entry.edits.is_empty();
        if usize::from(spelled) + usize::from(entry.built) + usize::from(entry.pack.is_some()) > 1 {
            return Err("one of a text, `built` and `pack`".into());
        }
        if entry.built {
            return built::bytes(table, &entry.name).ok_or("no such file is built".into());
        }
        if let Some(pack) = entry.pack {
            let inside = entry.inside.iter();
            let files: Result<Vec<_>, String> = inside
                .map(|(name, content)| Ok((name.clone(), self.content(content)?)))
                .collect();
            let files = files?;
            return Ok(match pack {
                Pack::Zip => zip_of(&files),
                Pack::Tar => tar_of(&files),
                Pack::TarGz => gzip_of(&tar_of(&files)),
            });
        }
        let mut spelling = Spelling {
            text: entry.text.take(),
            of: entry.of.take(),
            edits: std::mem::take(&mut entry.edits),
            everywhere: std::mem::take(&mut entry.everywhere),
            encoding: entry.encoding,
        };
        if !spelled {
            spelling.text.clone_from(&self.default.text);
        }
        self.spelled(&spelling)
    }

    /// The bytes of a file beside the first or inside of an archive.
    fn content(&self, content: &Value) -> Result<Vec<u8>, String> {
        match content {
            Value::String(text) => expand(text).map(String::into_bytes),
            spelling => {
                let spelling = Spelling::deserialize(spelling.clone());
                self.spelled(&spelling.map_err(|error| error.to_string().trim().to_string())?)
            }
        }
    }

    fn spelled(&self, spelling: &Spelling) -> Result<Vec<u8>, String> {
        let mut text = match (&spelling.text, &spelling.of) {
            (Some(text), None) => text.clone(),
            (None, Some(name)) => {
                let text = self.text.get(name);
                text.ok_or_else(|| format!("no text `{name}`"))?.clone()
            }
            _ => return Err("one of `text` and `of`".into()),
        };
        for (old, new) in &spelling.edits {
            match text.matches(old).count() {
                1 => text = text.replace(old, new),
                count => return Err(format!("`{old}` is {count} times in the text, not once")),
            }
        }
        let mut text = expand(&text)?;
        for (old, new) in &spelling.everywhere {
            if !text.contains(old) {
                return Err(format!("`{old}` is nowhere in the text"));
            }
            text = text.replace(old, new);
        }
        Ok(match spelling.encoding {
            Encoding::Utf8 => text.into_bytes(),
            Encoding::Latin1 => text
                .chars()
                .map(|c| u8::try_from(u32::from(c)).map_err(|_| format!("`{c}` is not in Latin-1")))
                .collect::<Result<_, _>>()?,
            Encoding::Utf16Le => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
            Encoding::Utf16Be => text.encode_utf16().flat_map(u16::to_be_bytes).collect(),
        })
    }

    fn read(&self, table: &str, entry: &Entry) -> Result<Read, String> {
        let own =
            |text: &Option<String>, default: &str| text.as_deref().unwrap_or(default).to_string();
        let values = match (entry.samples, &entry.values) {
            (Some(_), Some(_)) => return Err("`samples` are of unstated values".into()),
            (Some(_), None) => None,
            (None, Some(values)) if values == "built" => {
                Some(built::values(table, &entry.name).ok_or("no such values are built")?)
            }
            (None, values) => {
                let values = values.as_ref().unwrap_or(&self.default.values);
                Some(numbers(values, entry.scale).map_err(|reason| format!("values: {reason}"))?)
            }
        };
        Ok(Read {
            channel: own(&entry.channel, &self.default.channel),
            unit: own(&entry.unit, &self.default.unit),
            rate_hz: entry.rate.unwrap_or(10_000.0),
            start_s: entry.start.unwrap_or(-0.02),
            samples: entry
                .samples
                .or(values.as_ref().map(Vec::len))
                .expect("a number or values"),
            values,
        })
    }
}

impl Entry {
    /// True if something is said of what is read.
    fn reads(&self) -> bool {
        let words = [&self.channel, &self.unit, &self.values];
        let numbers = [self.rate, self.start, self.scale];
        words.iter().any(|word| word.is_some())
            || numbers.iter().any(Option::is_some)
            || self.samples.is_some()
    }
}

/// The numbers of the lines that a template stands for; of one without `{rows}`, for all rows.
fn numbers(template: &str, scale: Option<f64>) -> Result<Vec<f64>, String> {
    let text = match template.contains("{rows") {
        true => expand(template)?,
        false => expand(&format!("{{rows}}{template}\n"))?,
    };
    let number = |line: &str| line.parse().map_err(|_| format!("`{line}` is no number"));
    let numbers: Result<Vec<f64>, String> = text.lines().map(number).collect();
    Ok(match scale {
        None => numbers?,
        Some(scale) => numbers?.iter().map(|number| number * scale).collect(),
    })
}

#[track_caller]
fn check_broken(case: &str, reason: &str) {
    let head = "[default]\nchannel = \"y\"\nunit = \"g\"\nvalues = \"{g}\"\n[text]\nbase = \"a\\nb\\na\\n\"\n";
    let refusal = match parsed("tables", &format!("{head}[[case]]\n{case}")) {
        Ok(_) => panic!("{case}: taken"),
        Err(refusal) => refusal,
    };
    assert!(refusal.contains(reason), "{case}: {refusal}");
    assert!(refusal.contains("line "), "{case}: no place in {refusal}");
}

#[test]
fn verif_a_broken_table_is_refused_with_place_and_reason() {
    let good = "name = \"x.csv\"\ntext = \"a\"\n";
    for (case, reason) in [
        (good.to_string(), "line 7: case `x.csv`: it expects nothing"),
        (format!("{good}exit = 4"), "one of `exit` (0, 1 or 3)"),
        (
            format!("{good}exit = 0\nrefused = [\"no\"]"),
            "one of `exit` (0, 1 or 3)",
        ),
        (format!("{good}refused = []"), "words of the message"),
        (
            format!("{good}unusable = [\"no\"]"),
            "nothing that it finds blocks",
        ),
        (
            format!("{good}refused = [\"no\"]\nunit = \"g\""),
            "refused, and yet read",
        ),
        (
            format!("{good}exit = 0\nfind = [\"info x\"]"),
            "unknown field `find`",
        ),
        (
            format!("{good}exit = 0\nsamples = 3\nvalues = \"{{g}}\""),
            "unstated values",
        ),
        (
            format!("{good}exit = 0\nvalues = \"{{t}} s\""),
            "values: `-0.0200 s` is no number",
        ),
        (
            format!("{good}exit = 0\nbeside = {{ x = {{ off = \"base\" }} }}"),
            "x: unknown field `off`",
        ),
        (
            format!("{good}of = \"base\"\nexit = 0"),
            "one of `text` and `of`",
        ),
        (
            format!("{good}built = true\nexit = 0"),
            "one of a text, `built` and `pack`",
        ),
        (format!("{good}cut = 1\nexit = 0"), "`cut` leaves all"),
        (
            format!("{good}altered = \"so\"\nexit = 0"),
            "no such alteration",
        ),
        (
            format!("{good}everywhere = [[\"z\", \"y\"]]\nexit = 0"),
            "`z` is nowhere",
        ),
        ("name = \"x\"\nexit = 0".into(), "one of `text` and `of`"),
        (
            "name = \"x\"\nbuilt = true\nexit = 0".into(),
            "no such file is built",
        ),
        (
            "name = \"x\"\nof = \"bass\"\nexit = 0".into(),
            "no text `bass`",
        ),
        (
            "name = \"x\"\nof = \"base\"\nedits = [[\"a\", \"c\"]]\nexit = 0".into(),
            "`a` is 2 times",
        ),
        (
            "name = \"$2\"\neach = [\"a\"]\ntext = \"\"\nexit = 0".into(),
            "`$2` is no word",
        ),
        (
            "name = \"x\"\neach = []\ntext = \"\"\nexit = 0".into(),
            "`each` is no list, or empty",
        ),
        (
            "name = \"x\"\ntext = \"\u{20ac}\"\nencoding = \"latin-1\"\nexit = 0".into(),
            "not in Latin-1",
        ),
        (
            "name = \"x\"\ntext = \"{rows}{h}\"\nexit = 0".into(),
            "`{h}` is no token",
        ),
    ] {
        check_broken(&case, reason);
    }
}
