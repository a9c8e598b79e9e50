//! The wiring picture of a board.

use std::fmt::Write;

use super::board::Role::{self, *};
use super::board::{Board, Pin};

/// Lines on the right, to the drivers, from top to bottom, and what the driver calls them.
const DRIVER: [(Role, &str); 8] = [
    (LeftA, "left A"),
    (LeftB, "left B"),
    (LeftC, "left C, if it has one"),
    (RightA, "right A"),
    (RightB, "right B"),
    (RightC, "right C, if it has one"),
    (Enable, "enable"),
    (Fault, "fault, if it has one"),
];

/// Lines on the left.
const ENCODERS: [(Role, &str); 4] =
    [(LeftEncoderA, "A"), (LeftEncoderB, "B"), (RightEncoderA, "A"), (RightEncoderB, "B")];

const STYLE: &str = "\
<style>text{fill:#1b1f24}.box{fill:none;stroke:#5b6470;stroke-width:1.5}.wire{fill:none;stroke:#0369a1;\
stroke-width:1.6}.power{fill:none;stroke:#c2410c;stroke-width:1.6}.gnd{fill:none;stroke:#1b1f24;\
stroke-width:1.6}.part{fill:#fff;stroke:#5b6470;stroke-width:1.5}.pin{font-weight:bold}\
.place{fill:#5b6470}.end{text-anchor:end}.mid{text-anchor:middle}</style>";

/// The picture as an SVG file.
pub(super) fn draw(board: &Board) -> String {
    let name = board.name;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 960 560\" \
         font-family=\"system-ui,-apple-system,'Segoe UI',Roboto,sans-serif\" font-size=\"13\" role=\"img\" \
         aria-label=\"Wiring of a robot with a {name}\">\n<title>Wiring of a robot with a {name}</title>\n{STYLE}\n\
         <rect width=\"960\" height=\"560\" rx=\"12\" fill=\"#fff\"/>\n"
    );
    boxes(&mut svg, board);
    for (row, (role, label)) in ENCODERS.into_iter().enumerate() {
        let y = 85 + row * 30 + (row / 2) * 40;
        left(&mut svg, board.place(role), label, y);
    }
    for (row, (role, label)) in DRIVER.into_iter().enumerate() {
        right(&mut svg, board.place(role), label, 85 + row * 34);
    }
    stop(&mut svg, board.place(Stop));
    supply(&mut svg, board.place(Supply));
    svg += "</svg>\n";
    svg
}

fn put(svg: &mut String, text: std::fmt::Arguments) {
    svg.write_fmt(text).expect("a string takes all");
    svg.push('\n');
}

fn boxes(svg: &mut String, board: &Board) {
    let Board { name, link, ground, .. } = board;
    for (x, y, width, height) in [
        (330, 50, 260, 450),
        (20, 60, 150, 80),
        (20, 160, 150, 80),
        (20, 460, 150, 40),
        (760, 60, 180, 290),
        (760, 430, 180, 60),
    ] {
        put(
            svg,
            format_args!(
                "<rect class=\"box\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"5\"/>"
            ),
        );
    }
    put(
        svg,
        format_args!(
            "<path class=\"wire\" d=\"M170 480H330\"/><path class=\"power\" d=\"M850 430V350\"/>"
        ),
    );
    for (x, y, text) in [
        (460, 38, *name),
        (95, 104, "left encoder"),
        (95, 204, "right encoder"),
        (95, 485, "computer, USB"),
        (850, 48, "motor driver"),
        (850, 455, "battery"),
        (850, 475, "9 to 18 V"),
        (872, 395, "VM"),
    ] {
        put(svg, format_args!("<text class=\"mid\" x=\"{x}\" y=\"{y}\">{text}</text>"));
    }
    put(svg, format_args!("<text x=\"340\" y=\"485\">{link}</text>"));
    for (x, y) in [(95, 140), (95, 240), (460, 500), (930, 350), (930, 490)] {
        earth(svg, x, y);
    }
    put(svg, format_args!("<text x=\"475\" y=\"520\">GND, {ground}</text>"));
    put(
        svg,
        format_args!(
            "<text class=\"place\" x=\"20\" y=\"545\">All grounds are one. The encoders' supply: see the page.</text>"
        ),
    );
}

/// Ground, below this point.
fn earth(svg: &mut String, x: i32, y: i32) {
    put(svg, format_args!("<path class=\"gnd\" d=\"M{x} {y}v10m-9 0h18m-15 4h12m-9 4h6\"/>",));
}

fn left(svg: &mut String, Pin { pin, place, .. }: &Pin, label: &str, y: usize) {
    let text = y + 4;
    put(svg, format_args!("<path class=\"wire\" d=\"M170 {y}H330\"/>"));
    put(svg, format_args!("<text class=\"end\" x=\"162\" y=\"{text}\">{label}</text>"));
    put(svg, format_args!("<text class=\"pin\" x=\"340\" y=\"{text}\">{pin}</text>"));
    put(svg, format_args!("<text class=\"place end\" x=\"322\" y=\"{}\">{place}</text>", y - 4));
}

fn right(svg: &mut String, Pin { role, pin, place }: &Pin, label: &str, y: usize) {
    let text = y + 4;
    put(svg, format_args!("<path class=\"wire\" d=\"M590 {y}H760\"/>"));
    put(svg, format_args!("<text class=\"pin end\" x=\"580\" y=\"{text}\">{pin}</text>"));
    put(svg, format_args!("<text class=\"place\" x=\"598\" y=\"{}\">{place}</text>", y - 4));
    put(svg, format_args!("<text x=\"770\" y=\"{text}\">{label}</text>"));
    if *role == Enable {
        put(
            svg,
            format_args!(
                "<path class=\"gnd\" d=\"M730 {y}V{}\"/><circle cx=\"730\" cy=\"{y}\" r=\"3\"/>",
                y + 80
            ),
        );
        put(
            svg,
            format_args!(
                "<rect class=\"part\" x=\"721\" y=\"{}\" width=\"18\" height=\"36\"/>",
                y + 42
            ),
        );
        put(svg, format_args!("<text class=\"end\" x=\"714\" y=\"{}\">10 kΩ</text>", y + 65));
        earth(svg, 730, y as i32 + 80);
    }
}

/// The stop line, on the left.
fn stop(svg: &mut String, Pin { pin, place, .. }: &Pin) {
    put(
        svg,
        format_args!(
            "<path class=\"wire\" d=\"M330 310H210\"/><path class=\"wire\" d=\"M160 310H95\"/>"
        ),
    );
    put(
        svg,
        format_args!(
            "<path class=\"gnd\" d=\"M160 310L214 308\"/><circle cx=\"160\" cy=\"310\" r=\"3\"/><circle cx=\"210\" cy=\"310\" r=\"3\"/>"
        ),
    );
    put(svg, format_args!("<text class=\"pin\" x=\"340\" y=\"314\">{pin}</text>"));
    put(svg, format_args!("<text class=\"place end\" x=\"322\" y=\"306\">{place}</text>"));
    put(
        svg,
        format_args!(
            "<text class=\"mid\" x=\"185\" y=\"284\">stop switch, opens when pressed</text>"
        ),
    );
    earth(svg, 95, 310);
}

/// The supply's divider, from the battery to the board's right side.
fn supply(svg: &mut String, Pin { pin, place, .. }: &Pin) {
    put(svg, format_args!("<path class=\"power\" d=\"M760 460H746M686 460H590\"/>"));
    put(svg, format_args!("<rect class=\"part\" x=\"686\" y=\"451\" width=\"60\" height=\"18\"/>"));
    put(svg, format_args!("<text class=\"mid\" x=\"718\" y=\"445\">47 kΩ</text>"));
    put(
        svg,
        format_args!(
            "<path class=\"gnd\" d=\"M640 460V520\"/><circle cx=\"640\" cy=\"460\" r=\"3\"/>"
        ),
    );
    put(svg, format_args!("<rect class=\"part\" x=\"631\" y=\"474\" width=\"18\" height=\"36\"/>"));
    put(svg, format_args!("<text x=\"656\" y=\"497\">10 kΩ</text>"));
    earth(svg, 640, 520);
    put(svg, format_args!("<text class=\"pin end\" x=\"580\" y=\"464\">{pin}</text>"));
    put(svg, format_args!("<text class=\"place\" x=\"598\" y=\"452\">{place}</text>"));
}
