//! `beeline ports`: where a robot may be reached.

use serde_json::json;
use serialport::SerialPortType;

use crate::cli::Common;
use crate::error::{Context, Result};
use crate::ui::{BOLD, DIM, paint, say};

pub(super) fn run(common: &Common) -> Result<()> {
    let ports = serialport::available_ports().context("cannot list the serial ports")?;
    let ports: Vec<_> =
        ports.into_iter().map(|port| (port.port_name, describe(&port.port_type))).collect();
    if common.json {
        let ports: Vec<_> =
            ports.iter().map(|(name, kind)| json!({"port": name, "is": kind})).collect();
        say(json!({ "ports": ports }));
        return Ok(());
    }
    let width =
        ports.iter().map(|(name, _)| name.len()).max().unwrap_or(0).max("tcp:HOST:PORT".len());
    for (name, kind) in &ports {
        say(format_args!("{}  {kind}", paint(BOLD, format_args!("{name:<width$}"))));
    }
    if ports.is_empty() {
        say(paint(DIM, "no serial port is plugged in"));
    }
    for (name, kind) in [
        ("sim", "a simulated robot in this process, faster than real time"),
        ("sim:FILE.toml", "another one; `beeline sim --scenario` prints a file to start from"),
        ("tcp:HOST:PORT", "a robot, or `beeline sim --listen`, on the network"),
    ] {
        say(format_args!("{}  {kind}", paint(BOLD, format_args!("{name:<width$}"))));
    }
    Ok(())
}

fn describe(kind: &SerialPortType) -> String {
    match kind {
        SerialPortType::UsbPort(usb) => {
            let product = usb.product.as_deref().unwrap_or("USB serial port");
            match &usb.manufacturer {
                Some(maker) => format!("{product}, {maker} ({:04x}:{:04x})", usb.vid, usb.pid),
                None => format!("{product} ({:04x}:{:04x})", usb.vid, usb.pid),
            }
        }
        SerialPortType::PciPort => "serial port of this computer".into(),
        SerialPortType::BluetoothPort => "Bluetooth serial port".into(),
        SerialPortType::Unknown => "serial port".into(),
    }
}
