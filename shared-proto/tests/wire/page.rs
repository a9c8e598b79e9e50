//! docs/protocol.md says what this build does.

use postcard_schema::Schema;
use postcard_schema::schema::{DataModelType, DataModelVariant, NamedType, NamedValue};
use shared_proto::*;

use crate::golden;

/// The page, which lies outside of this crate.
fn page() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/protocol.md");
    std::fs::read_to_string(path).expect("docs/protocol.md is there")
}

/// The fenced block that follows this mark.
fn block<'p>(page: &'p str, mark: &str) -> &'p str {
    let start = page.find(mark).unwrap_or_else(|| panic!("{mark} is in the page"));
    let text = &page[start..];
    let open = text.find("```text\n").expect("a block") + "```text\n".len();
    let len = text[open..].find("```").expect("the block's end");
    &text[open..open + len]
}

/// `u32`, `WheelPair<f64>`: how the page calls a type.
fn name(ty: &NamedType) -> String {
    match ty.ty {
        DataModelType::Option(inner) => format!("Option<{}>", name(inner)),
        DataModelType::Tuple(items) => format!("[{}; {}]", name(items[0]), items.len()),
        DataModelType::String => "string".to_string(),
        DataModelType::Struct(fields) if ty.name == "WheelPair" => {
            format!("WheelPair<{}>", name(fields[0].ty))
        }
        DataModelType::Enum([ok, err]) if ty.name.starts_with("Result") => {
            let inner = |variant: &DataModelVariant| match variant {
                DataModelVariant::TupleVariant([inner]) => name(inner),
                other => panic!("{other:?} in a result"),
            };
            format!("Result<{}, {}>", inner(ok.ty), inner(err.ty))
        }
        _ => ty.name.to_string(),
    }
}

fn fields(fields: &[&NamedValue]) -> String {
    let fields = fields.iter().map(|field| format!("{}: {}", field.name, name(field.ty)));
    fields.collect::<Vec<_>>().join(", ")
}

/// Adds the layout of a type to the list, and of all that it consists of.
fn list(ty: &NamedType, lines: &mut Vec<String>) {
    let mut below: Vec<&NamedType> = Vec::new();
    let mut layout = None;
    match ty.ty {
        DataModelType::Option(inner) => below.push(inner),
        DataModelType::Tuple(items) => below.push(items[0]),
        DataModelType::NewtypeStruct(inner) => layout = Some(name(inner)),
        DataModelType::Struct(of) => {
            below.extend(of.iter().map(|field| field.ty));
            if ty.name != "WheelPair" {
                layout = Some(format!("{{ {} }}", fields(of)));
            }
        }
        DataModelType::Enum(variants) => {
            let mut text = String::new();
            for (number, variant) in variants.iter().enumerate() {
                text += &format!("\n    {number} {}", variant.name);
                match variant.ty {
                    DataModelVariant::UnitVariant => {}
                    DataModelVariant::NewtypeVariant(inner) => {
                        text += &format!("({})", name(inner));
                        below.push(inner);
                    }
                    DataModelVariant::TupleVariant(items) => below.extend(items.iter()),
                    DataModelVariant::StructVariant(of) => {
                        text += &format!(" {{ {} }}", fields(of));
                        below.extend(of.iter().map(|field| field.ty));
                    }
                }
            }
            if !ty.name.starts_with("Result") {
                layout = Some(text);
            }
        }
        _ => {}
    }
    if let Some(layout) = layout {
        let separator = if layout.starts_with('\n') { " =" } else { " = " };
        let line = format!("{}{separator}{layout}\n", ty.name);
        if lines.contains(&line) {
            return;
        }
        lines.push(line);
    }
    below.into_iter().for_each(|ty| list(ty, lines));
}

#[test]
fn the_layouts_in_the_page_are_those_of_this_build() {
    let mut lines = Vec::new();
    for ty in [Request::SCHEMA, Reply::SCHEMA, Telemetry::SCHEMA, Event::SCHEMA] {
        list(ty, &mut lines);
    }
    let built = lines.concat();
    assert!(built == block(&page(), "## Layouts"), "docs/protocol.md should say:\n{built}");
}

#[test]
fn the_frames_in_the_page_are_the_golden_ones() {
    let page = page();
    let mut checked = 0;
    for (name, value) in golden::lines() {
        for line in page.lines() {
            if let Some((_, shown)) = line.split_once(&format!("{name} = ")) {
                assert_eq!(shown.replace(' ', ""), value, "{name}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 5, "frames in docs/protocol.md");
}

#[test]
fn the_worked_example_in_the_page_adds_up() {
    let page = page();
    let shown = |label: &str| {
        let line = block(&page, "## An example")
            .lines()
            .find_map(|line| line.strip_prefix(label))
            .unwrap_or_else(|| panic!("a line `{label}`"));
        let bytes = line.split("  ").map(str::trim).find(|part| !part.is_empty()).expect("bytes");
        golden::from_hex(&bytes.replace(' ', ""))
    };
    let frame = golden::frame("request.subscribe");
    let (channel, payload) = crate::decoding::parts(&frame);
    assert_eq!(channel, Channel::Request);
    assert_eq!(shown("payload"), payload);
    assert_eq!(shown("frame"), frame);
    let raw = shown("with header and CRC");
    assert_eq!(raw[..3], [1, 0, 0]);
    assert_eq!(raw[3..raw.len() - 4], payload);
    let mut decoded = frame[..frame.len() - 1].to_vec();
    let len = cobs::decode_in_place(&mut decoded).unwrap();
    assert_eq!(decoded[..len], raw);
}

#[test]
fn the_limits_in_the_page_are_those_of_this_build() {
    // In one line, so that a sentence may be broken anywhere.
    let page = page().split_whitespace().collect::<Vec<_>>().join(" ");
    let config = |path| Config::FIELDS.iter().find(|field| field.path == path).unwrap();
    let timeout = config("protection.link_timeout_s");
    for said in [
        format!("payload of at most {PAYLOAD_LEN_MAX} bytes"),
        format!("{FRAME_LEN_MAX} bytes on the wire"),
        format!("at most {} ms ahead", Request::LEASE_MS_MAX),
        format!("{} to {} s", timeout.min, timeout.max),
        format!("at most {NAME_LEN_MAX} bytes"),
        format!("protocol version is {PROTOCOL_VERSION} "),
        format!("0x{SCHEMA_HASH:016x}"),
    ] {
        assert!(page.contains(&said), "docs/protocol.md should say `{said}`");
    }
}
