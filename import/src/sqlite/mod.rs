//! SQLite, the older file format of ROS 2 bags (`.db3`): two tables, `topics` and `messages`.
//!
//! Of [the format](https://www.sqlite.org/fileformat2.html) only what reading a table from its beginning to its end needs: no
//! index, no query, no change. A file is read page by page, and what is damaged is left out. `metadata.yaml` beside it is not
//! needed. What a recorder has not brought into the file yet, in a file `-wal` beside it, is not read.
//!
//! | file | what it is |
//! | --- | --- |
//! | `pages.rs` | pages, and the rows of a table in them |
//! | `row.rs` | the values of a row |

mod pages;
mod row;

use std::collections::HashMap;
use std::io::{self, Read, Seek};

use crate::received::{Channel, Damage, Received};
pub use pages::MAGIC;
use pages::Pages;
use row::{Value, values};

/// Why nothing at all can be read.
#[derive(Debug)]
pub enum ReadError {
    /// The system refused.
    Io(io::Error),
    /// It is no SQLite file.
    NotSqlite,
    /// It has not the two tables of a bag.
    NoBag,
}

/// The table of tables begins on the first page.
const SCHEMA: u32 = 1;
/// More topics are no robot, and would only fill the memory.
const TOPICS_MAX: usize = 10_000;

/// A table: where it begins, and its columns.
#[derive(Clone, Debug, Default, PartialEq)]
struct Table {
    root: u32,
    columns: Vec<String>,
}

/// Gives every message of a bag to `each`, in the order in which they were recorded; what is damaged is the result.
pub fn read(
    file: impl Read + Seek,
    mut each: impl FnMut(Received<'_>),
) -> Result<Vec<Damage>, ReadError> {
    let mut pages = Pages::open(file).map_err(ReadError::Io)?.ok_or(ReadError::NotSqlite)?;
    let [topics, messages] = tables(&mut pages).map_err(ReadError::Io)?.ok_or(ReadError::NoBag)?;
    let mut channels: HashMap<i64, Channel> = HashMap::new();
    let mut damaged = 0;
    let columns = ["name", "type", "serialization_format"].map(|name| topics.column(name));
    let read = pages.rows(topics.root, &mut |id, record| {
        let channel = values(record).and_then(|values| {
            let [Some(topic), Some(schema), Some(encoding)] =
                columns.map(|column| text(values.get(column?)?))
            else {
                return None;
            };
            Some(Channel { topic, schema, encoding })
        });
        match channel {
            Some(channel) if channels.len() < TOPICS_MAX => drop(channels.insert(id, channel)),
            _ => damaged += 1,
        }
    });
    read.map_err(ReadError::Io)?;
    let columns = ["topic_id", "timestamp", "data"].map(|name| messages.column(name));
    let is_cut_off = pages.is_cut_off;
    let mut message = |_: i64, record: &[u8]| {
        let values = values(record).unwrap_or_default();
        let [topic, timestamp, data] =
            columns.map(|column| column.and_then(|column| values.get(column)).copied());
        let (
            Some(Value::Integer(topic)),
            Some(Value::Integer(nanoseconds)),
            Some(Value::Blob(bytes)),
        ) = (topic, timestamp, data)
        else {
            // Among the rows of all tables, those of others are no damage.
            damaged += usize::from(!is_cut_off);
            return;
        };
        match channels.get(&topic) {
            Some(channel) => {
                each(Received { channel, log_time_s: nanoseconds as f64 * 1e-9, bytes });
            }
            None => damaged += 1,
        }
    };
    let read = match is_cut_off {
        true => pages.all_rows(&mut message),
        false => pages.rows(messages.root, &mut message),
    };
    read.map_err(ReadError::Io)?;
    let mut damage = pages.damage;
    if damaged > 0 {
        damage.push(Damage::Rows { count: damaged });
    }
    Ok(damage)
}

/// The tables `topics` and `messages`.
fn tables(pages: &mut Pages<impl Read + Seek>) -> io::Result<Option<[Table; 2]>> {
    let mut found: [Option<Table>; 2] = [None, None];
    pages.rows(SCHEMA, &mut |_, record| {
        // type, name, table, root page, the statement that made it
        let values = values(record).unwrap_or_default();
        let Some(
            [Value::Text(b"table"), Value::Text(name), _, Value::Integer(root), Value::Text(sql)],
        ) = values.get(..5)
        else {
            return;
        };
        let Ok(root) = u32::try_from(*root) else { return };
        let table = Table { root, columns: columns(&String::from_utf8_lossy(sql)) };
        match *name {
            b"topics" => found[0] = Some(table),
            b"messages" => found[1] = Some(table),
            _ => {}
        }
    })?;
    let [topics, messages] = found;
    Ok(topics.zip(messages).map(|(topics, messages)| [topics, messages]))
}

/// The names of the columns: the first words between the commas of the statement.
fn columns(sql: &str) -> Vec<String> {
    let inner = sql.split_once('(').map_or("", |(_, inner)| inner);
    let words = inner.split(',').filter_map(|column| column.split_whitespace().next());
    words.map(|word| word.trim_matches(['"', '`', '[', ']', ')']).to_ascii_lowercase()).collect()
}

impl Table {
    fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}

fn text(value: &Value<'_>) -> Option<String> {
    match value {
        Value::Text(bytes) => Some(String::from_utf8_lossy(bytes).into_owned()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_of_a_statement_have_their_names() {
        let sql = "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL, \"timestamp\" INTEGER, data BLOB NOT NULL)";
        assert_eq!(columns(sql), ["id", "topic_id", "timestamp", "data"]);
        assert_eq!(columns("no table"), [""; 0]);
    }
}
