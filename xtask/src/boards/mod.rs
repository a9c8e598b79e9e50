//! `cargo xtask boards`: the pin table and the wiring picture of each board's page, from one table.
//!
//! The check compares the pages with the table, and the table with the pins that the images' code names.
//! Connector numbers are those of ST's user manuals (UM1974, UM1724, UM2505) and of the print on the Black Pill.

use std::fmt::Write;
use std::path::PathBuf;

use crate::repository::root;
use crate::steps::Outcome;

mod board;
mod picture;

use board::{Board, Pin, Role};

const fn pin(role: Role, pin: &'static str, place: &'static str) -> Pin {
    Pin { role, pin, place }
}

use Role::*;

/// What the NUCLEO-64 boards have. The G474RE has its chip's pins on the same places of the same connectors.
const NUCLEO_64: Board = Board {
    name: "NUCLEO-F446RE",
    file: "nucleo-f446re",
    sources: &["firmware/src/bin/wiring/usart2.rs", "firmware/src/bin/wiring/nucleo_64.rs"],
    pins: [
        pin(LeftEncoderA, "PC6", "CN10-4"),
        pin(LeftEncoderB, "PC7", "CN10-19, D9"),
        pin(RightEncoderA, "PB6", "CN10-17, D10"),
        pin(RightEncoderB, "PB7", "CN7-21"),
        pin(LeftA, "PA8", "CN10-23, D7"),
        pin(LeftB, "PA9", "CN10-21, D8"),
        pin(LeftC, "PA6", "CN10-13, D12"),
        pin(RightA, "PA10", "CN10-33, D2"),
        pin(RightB, "PA11", "CN10-14"),
        pin(RightC, "PA7", "CN10-15, D11"),
        pin(Enable, "PB10", "CN10-25, D6"),
        pin(Fault, "PB5", "CN10-29, D4"),
        pin(Stop, "PB12", "CN10-16"),
        pin(Supply, "PA0", "CN7-28, A0"),
    ],
    ground: "CN10-20",
    link: "ST-LINK (USART2)",
};

/// The boards with a page.
const BOARDS: [Board; 5] = [
    Board {
        name: "NUCLEO-F429ZI",
        file: "nucleo-f429zi",
        sources: &[],
        pins: [
            pin(LeftEncoderA, "PC6", "CN7-1, D16"),
            pin(LeftEncoderB, "PC7", "CN7-11, D21"),
            pin(RightEncoderA, "PD12", "CN10-21, D29"),
            pin(RightEncoderB, "PD13", "CN10-19, D28"),
            pin(LeftA, "PE9", "CN10-4, D6"),
            pin(LeftB, "PE11", "CN10-6, D5"),
            pin(LeftC, "PE10", "CN10-24, D40"),
            pin(RightA, "PE13", "CN10-10, D3"),
            pin(RightB, "PE14", "CN10-28, D38"),
            pin(RightC, "PE12", "CN10-26, D39"),
            pin(Enable, "PF15", "CN10-12, D2"),
            pin(Fault, "PF14", "CN10-8, D4"),
            pin(Stop, "PE15", "CN10-30, D37"),
            pin(Supply, "PA3", "CN9-1, A0"),
        ],
        ground: "CN10-22",
        link: "ST-LINK (USART3)",
    },
    NUCLEO_64,
    Board { name: "NUCLEO-F411RE", file: "nucleo-f411re", ..NUCLEO_64 },
    Board {
        name: "NUCLEO-G474RE",
        file: "nucleo-g474re",
        sources: &["firmware/src/bin/wiring/usart2.rs"],
        ..NUCLEO_64
    },
    Board {
        name: "Black Pill F411",
        file: "black-pill-f411",
        sources: &["firmware/src/bin/wiring/usart2.rs"],
        pins: [
            pin(LeftEncoderA, "PA6", "A6"),
            pin(LeftEncoderB, "PA7", "A7"),
            pin(RightEncoderA, "PB6", "B6"),
            pin(RightEncoderB, "PB7", "B7"),
            pin(LeftA, "PA8", "A8"),
            pin(LeftB, "PA9", "A9"),
            pin(LeftC, "PB13", "B13"),
            pin(RightA, "PA10", "A10"),
            pin(RightB, "PA11", "A11"),
            pin(RightC, "PB14", "B14"),
            pin(Enable, "PB10", "B10"),
            pin(Fault, "PB5", "B5"),
            pin(Stop, "PB12", "B12"),
            pin(Supply, "PA1", "A1"),
        ],
        ground: "G",
        link: "serial adapter (A2, A3)",
    },
];

/// Writes every page's table and picture.
pub fn write() -> Outcome {
    for board in &BOARDS {
        let [page, picture] = board.files()?;
        for (path, text) in [page, picture] {
            std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
            println!("    {}", path.display());
        }
    }
    Ok(())
}

/// Every page is that of the table, and the table that of the code.
pub fn check() -> Outcome {
    for board in &BOARDS {
        board.is_that_of_the_code()?;
        for (path, text) in board.files()? {
            let present = std::fs::read_to_string(&path).unwrap_or_default();
            if present != text {
                let path = path.display();
                return Err(format!("{path} is not that of the table: run `cargo xtask boards`"));
            }
        }
    }
    Ok(())
}

impl Role {
    fn text(self) -> &'static str {
        match self {
            LeftEncoderA => "left encoder A",
            LeftEncoderB => "left encoder B",
            RightEncoderA => "right encoder A",
            RightEncoderB => "right encoder B",
            LeftA => "left motor, line A",
            LeftB => "left motor, line B",
            LeftC => "left motor, line C",
            RightA => "right motor, line A",
            RightB => "right motor, line B",
            RightC => "right motor, line C",
            Enable => "enable of both drivers",
            Fault => "fault of both drivers",
            Stop => "stop line",
            Supply => "supply, divided",
        }
    }

    /// How the code names a pin of this role: one of these is in it.
    fn in_code(self, pin: &str) -> [String; 2] {
        let field = |name: &str| [format!("{name}: p.{pin},"), String::new()];
        match self {
            LeftEncoderA => [format!("(p.TIM3, p.{pin}, "), format!("left_encoder: {pin} ")],
            LeftEncoderB => [format!(", p.{pin}), (p.TIM4"), format!(" {pin}, lines_c:")],
            RightEncoderA => [format!("(p.TIM4, p.{pin}, "), String::new()],
            RightEncoderB => [format!(", p.{pin}));"), String::new()],
            LeftA => field("left_a"),
            LeftB => field("left_b"),
            LeftC => [format!("left_c: p.{pin},"), format!("lines_c: {pin} ")],
            RightA => field("right_a"),
            RightB => field("right_b"),
            RightC => [format!("right_c: p.{pin},"), format!(" {pin}, supply:")],
            Enable => field("enable"),
            Fault => [format!("driver_fault = PolledInput::active_low(p.{pin})"), String::new()],
            Stop => field("stop"),
            Supply => [format!("(p.ADC1, p.{pin}, "), format!("supply: {pin} channel")],
        }
    }
}

impl Board {
    fn place(&self, role: Role) -> &Pin {
        self.pins.iter().find(|pin| pin.role == role).expect("every board has every role")
    }

    fn is_that_of_the_code(&self) -> Outcome {
        let binary = format!("firmware/src/bin/{}.rs", self.file.replace('-', "_"));
        let mut code = String::new();
        for file in self.sources.iter().copied().chain([binary.as_str()]) {
            code += &std::fs::read_to_string(root().join(file))
                .map_err(|error| format!("{file}: {error}"))?;
        }
        let code = code.split_whitespace().collect::<Vec<_>>().join(" ");
        for Pin { role, pin, .. } in &self.pins {
            let named = role.in_code(pin);
            if !named.iter().any(|named| !named.is_empty() && code.contains(named)) {
                let (name, role) = (self.name, role.text());
                return Err(format!("{name}: {binary} does not name {pin} as the {role}"));
            }
        }
        Ok(())
    }

    /// The page with its table, and the picture.
    fn files(&self) -> Result<[(PathBuf, String); 2], String> {
        let path = |end: &str| root().join("docs/boards").join(format!("{}.{end}", self.file));
        let page = std::fs::read_to_string(path("md"))
            .map_err(|error| format!("{}: {error}", path("md").display()))?;
        let start = page.find("| line | pin |").ok_or("a board's page has no pin table")?;
        let end = start + page[start..].find("\n\n").ok_or("the pin table does not end")?;
        let page = format!("{}{}{}", &page[..start], self.table(), &page[end..]);
        Ok([(path("md"), page), (path("svg"), picture::draw(self))])
    }

    fn table(&self) -> String {
        let mut table = "| line | pin | on the board |\n| --- | --- | --- |".to_string();
        for Pin { role, pin, place } in &self.pins {
            write!(table, "\n| {} | {pin} | {place} |", role.text()).expect("a string takes all");
        }
        write!(table, "\n| ground of all | GND | {} |", self.ground).expect("a string takes all");
        table
    }
}
