//! Workbooks of Excel, byte by byte.

use super::archive::zip_of;
use std::fmt::Write as _;
use std::io::Write as _;

/// A cell, in the words of either format.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    None,
    Number(f64),
    /// A number with a format, by its place in [`Workbook::formats`], counted from 1.
    Formatted(f64, usize),
    Text(String),
    /// Of XML alone: what stands in the tag `c` behind its name, and its inside.
    Xml(&'static str, String),
}

pub fn text(text: impl Into<String>) -> Cell {
    Cell::Text(text.into())
}

/// A sheet of a workbook in XML.
#[derive(Debug, Clone, Default)]
pub struct Sheet {
    pub name: &'static str,
    /// Further attributes in the list of sheets.
    pub state: &'static str,
    pub before_rows: &'static str,
    pub rows: Vec<Vec<Cell>>,
    /// Attributes of rows, by their number from 0.
    pub row_attributes: Vec<(usize, &'static str)>,
    pub after_rows: &'static str,
    /// Notes, with the cell of each.
    pub notes: Vec<(&'static str, &'static str)>,
}

/// A workbook in XML.
#[derive(Debug, Clone, Default)]
pub struct Workbook {
    /// What stands before the list of sheets, and behind it.
    pub properties: &'static str,
    pub calculation: &'static str,
    pub formats: Vec<&'static str>,
    pub sheets: Vec<Sheet>,
    /// Further parts.
    pub parts: Vec<(&'static str, String)>,
}

/// A workbook of one sheet of these rows.
pub fn of_rows(rows: Vec<Vec<Cell>>) -> Workbook {
    Workbook {
        sheets: vec![Sheet {
            name: "Data",
            rows,
            ..Sheet::default()
        }],
        ..Workbook::default()
    }
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('"', "&quot;")
}

fn name_of(row: usize, column: usize) -> String {
    format!(
        "{}{}",
        char::from(b'A' + u8::try_from(column).unwrap()),
        row + 1
    )
}

impl Sheet {
    fn xml(&self) -> String {
        let mut xml = format!("<worksheet>{}<sheetData>", self.before_rows);
        for (row, cells) in self.rows.iter().enumerate() {
            let attributes = self
                .row_attributes
                .iter()
                .find(|(number, _)| *number == row);
            let attributes = attributes.map_or("", |(_, attributes)| attributes);
            write!(xml, "<row r=\"{}\" {attributes}>", row + 1).unwrap();
            for (column, cell) in cells.iter().enumerate() {
                let name = name_of(row, column);
                let cell = match cell {
                    Cell::None => continue,
                    Cell::Number(value) => format!("<c r=\"{name}\"><v>{value:?}</v></c>"),
                    Cell::Formatted(value, format) => {
                        format!("<c r=\"{name}\" s=\"{format}\"><v>{value:?}</v></c>")
                    }
                    Cell::Text(text) => {
                        let text = escaped(text);
                        format!("<c r=\"{name}\" t=\"inlineStr\"><is><t>{text}</t></is></c>")
                    }
                    Cell::Xml(attributes, inner) => {
                        format!("<c r=\"{name}\" {attributes}>{inner}</c>")
                    }
                };
                xml += &cell;
            }
            xml += "</row>";
        }
        xml + "</sheetData>" + self.after_rows + "</worksheet>"
    }
}

impl Workbook {
    pub fn parts(&self) -> Vec<(String, Vec<u8>)> {
        let mut parts = vec![("[Content_Types].xml".to_string(), "<Types/>".to_string())];
        let (mut sheets, mut relations, mut formats, mut cells) =
            (String::new(), String::new(), String::new(), String::new());
        for (index, sheet) in self.sheets.iter().enumerate() {
            let (name, state, number) = (escaped(sheet.name), sheet.state, index + 1);
            sheets += &format!(
                "<sheet name=\"{name}\" sheetId=\"{number}\" {state} r:id=\"r{number}\"/>"
            );
            let target = format!("worksheets/sheet{number}.xml");
            relations += &format!(
                "<Relationship Id=\"r{number}\" Type=\"x/worksheet\" Target=\"{target}\"/>"
            );
            parts.push((format!("xl/{target}"), sheet.xml()));
            if !sheet.notes.is_empty() {
                let note = |(cell, text): &(&str, &str)| {
                    format!(
                        "<comment ref=\"{cell}\"><text><r><t>{}</t></r></text></comment>",
                        escaped(text)
                    )
                };
                let notes: String = sheet.notes.iter().map(note).collect();
                parts.push((
                    format!("xl/comments{number}.xml"),
                    format!("<comments>{notes}</comments>"),
                ));
                let relation = format!(
                    "<Relationships><Relationship Id=\"n\" Type=\"x/comments\" Target=\"../comments{number}.xml\"/></Relationships>"
                );
                parts.push((
                    format!("xl/worksheets/_rels/sheet{number}.xml.rels"),
                    relation,
                ));
            }
        }
        for (index, code) in self.formats.iter().enumerate() {
            let (number, code) = (164 + index, escaped(code));
            formats += &format!("<numFmt numFmtId=\"{number}\" formatCode=\"{code}\"/>");
            cells += &format!("<xf numFmtId=\"{number}\"/>");
        }
        relations += "<Relationship Id=\"s\" Type=\"x/styles\" Target=\"/xl/styles.xml\"/>";
        parts.push((
            "xl/styles.xml".into(),
            format!("<styleSheet><numFmts>{formats}</numFmts><cellXfs><xf numFmtId=\"0\"/>{cells}</cellXfs></styleSheet>"),
        ));
        parts.push((
            "xl/_rels/workbook.xml.rels".into(),
            format!("<Relationships>{relations}</Relationships>"),
        ));
        let (properties, calculation) = (self.properties, self.calculation);
        parts.push((
            "xl/workbook.xml".into(),
            format!("<workbook>{properties}<sheets>{sheets}</sheets>{calculation}</workbook>"),
        ));
        let mut parts: Vec<(String, Vec<u8>)> = parts
            .into_iter()
            .map(|(name, text)| (name, text.into_bytes()))
            .collect();
        for (name, content) in &self.parts {
            parts.retain(|(other, _)| other != name);
            parts.push(((*name).into(), content.as_bytes().to_vec()));
        }
        parts
    }

    pub fn bytes(&self) -> Vec<u8> {
        zip_of(&self.parts())
    }

    /// Changes the first sheet.
    pub fn change(mut self, change: impl FnOnce(&mut Sheet)) -> Self {
        change(&mut self.sheets[0]);
        self
    }
}

/// Records of a workbook of Excel 97 to 2003.
#[derive(Debug, Clone, Default)]
pub struct Records(pub Vec<u8>);

impl Records {
    pub fn put(&mut self, kind: u16, data: &[u8]) -> &mut Self {
        let length = u16::try_from(data.len()).unwrap();
        self.0.extend(kind.to_le_bytes());
        self.0.extend(length.to_le_bytes());
        self.0.extend(data);
        self
    }

    fn cell(&mut self, kind: u16, (row, column): (usize, usize), format: usize, rest: &[u8]) {
        let words = [row, column, format].map(|word| u16::try_from(word).unwrap().to_le_bytes());
        self.put(kind, &[words.as_flattened(), rest].concat());
    }

    /// Puts the cells of a sheet, its texts beside them.
    pub fn rows(&mut self, rows: &[Vec<Cell>]) {
        self.rows_from(0, rows);
    }

    /// Puts the cells of rows from one on, counted from 0.
    pub fn rows_from(&mut self, first: usize, rows: &[Vec<Cell>]) {
        for (row, cells) in (first..).zip(rows) {
            for (column, cell) in cells.iter().enumerate() {
                let place = (row, column);
                match cell {
                    Cell::None => {}
                    Cell::Number(value) => self.cell(0x0203, place, 0, &value.to_le_bytes()),
                    Cell::Formatted(value, format) => {
                        self.cell(0x0203, place, *format, &value.to_le_bytes());
                    }
                    Cell::Text(text) => {
                        let units: Vec<u8> =
                            text.encode_utf16().flat_map(u16::to_le_bytes).collect();
                        let count = u16::try_from(units.len() / 2).unwrap().to_le_bytes();
                        self.cell(0x0204, place, 0, &[&count[..], &[1], &units].concat());
                    }
                    Cell::Xml(..) => panic!("no cell of this format"),
                }
            }
        }
    }
}

const BOF: u16 = 0x0809;
const EOF: u16 = 0x000A;

fn beginning(kind: u16) -> Vec<u8> {
    let words = [0x0600, kind, 0x0DBB, 1996, 0, 0, 6, 0];
    words.into_iter().flat_map(u16::to_le_bytes).collect()
}

/// An .xls file of one sheet; `globals` are further records of the workbook, `sheet` those of the sheet.
pub fn xls(globals: &Records, sheet: &Records) -> Vec<u8> {
    let mut stream = Records::default();
    stream.put(BOF, &beginning(5));
    stream.0.extend(&globals.0);
    let name = b"Data";
    let length = u8::try_from(name.len()).unwrap();
    let list = stream.0.len() + 4 + 8 + name.len() + 4;
    let place = u32::try_from(list).unwrap().to_le_bytes();
    stream.put(0x0085, &[&place[..], &[0, 0, length, 0], name].concat());
    stream.put(EOF, &[]);
    stream.put(BOF, &beginning(16));
    stream.0.extend(&sheet.0);
    stream.put(EOF, &[]);
    container("Workbook", &stream.0)
}

/// An OLE2 container of one stream.
pub fn container(name: &str, stream: &[u8]) -> Vec<u8> {
    let empty = std::io::Cursor::new(Vec::new());
    let mut container = cfb::CompoundFile::create_with_version(cfb::Version::V3, empty).unwrap();
    let mut opened = container.create_stream(name).unwrap();
    opened.write_all(stream).unwrap();
    drop(opened);
    container.flush().unwrap();
    container.into_inner().into_inner()
}
