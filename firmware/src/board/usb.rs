//! The link over the board's own USB connector: a serial port (CDC-ACM) in place of the UART.
//!
//! The same link tasks run on this port. A host that does not read makes frames wait, never the robot:
//! the supervisor does not wait until a reply is sent.
//!
//! On chips before revision 3 (`DBGMCU_IDCODE` below 0x2000) the second flash bank, where the
//! configuration lives, cannot be read while PA12 carries D+ (ES0206, 2.2.14). There the robot has its factory
//! configuration, and `beeline config save` is refused.

use core::fmt::Write as _;

use embassy_executor::Spawner;
use embassy_stm32::peripherals::USB_OTG_FS;
use embassy_stm32::usb::{DmPin, DpPin, Driver, InterruptHandler};
use embassy_stm32::{Peri, interrupt, usb};
use embassy_usb::class::cdc_acm::{BufferedReceiver, CdcAcmClass, Sender, State};
use embassy_usb::driver::EndpointError;
use embassy_usb::{Builder, Config, UsbDevice};
use embedded_io_async::{ErrorType, Read, Write};
use static_cell::StaticCell;

use super::NAME;
use super::tasks::{BoardShared, once};
use crate::task::link;

type Otg = Driver<'static, USB_OTG_FS>;

/// Longest packet at full speed.
const PACKET_LEN: u16 = 64;

/// Test numbers of pid.codes. A product needs numbers of its own.
const VENDOR_AND_PRODUCT: (u16, u16) = (0x1209, 0x0001);

/// Buffers of the device and its class: 0.9 KiB.
struct Memory {
    endpoint: [u8; 256],
    configuration: [u8; 128],
    bos: [u8; 16],
    control: [u8; 64],
    received: [u8; PACKET_LEN as usize],
    serial: heapless::String<24>,
}

static MEMORY: StaticCell<Memory> = StaticCell::new();
static STATE: StaticCell<State<'static>> = StaticCell::new();

/// Starts the USB device and the link tasks.
pub fn spawn(
    spawner: Spawner,
    shared: &'static BoardShared,
    peripheral: Peri<'static, USB_OTG_FS>,
    irq: impl interrupt::typelevel::Binding<interrupt::typelevel::OTG_FS, InterruptHandler<USB_OTG_FS>>
    + 'static,
    dp: Peri<'static, impl DpPin<USB_OTG_FS>>,
    dm: Peri<'static, impl DmPin<USB_OTG_FS>>,
) {
    let memory = MEMORY.init(Memory {
        endpoint: [0; 256],
        configuration: [0; 128],
        bos: [0; 16],
        control: [0; 64],
        received: [0; PACKET_LEN as usize],
        serial: heapless::String::new(),
    });
    for byte in embassy_stm32::uid::uid() {
        let _ = write!(memory.serial, "{byte:02x}");
    }
    let mut line = usb::Config::default();
    // The ST-LINK or the robot powers the board, so the cable's supply says nothing.
    line.vbus_detection = false;
    let driver = Driver::new_fs(peripheral, irq, dp, dm, &mut memory.endpoint, line);
    let (vendor, product) = VENDOR_AND_PRODUCT;
    let mut config = Config::new(vendor, product);
    config.manufacturer = Some("Beeline");
    config.product = Some(NAME);
    config.serial_number = Some(&memory.serial);
    let mut builder = Builder::new(
        driver,
        config,
        &mut memory.configuration,
        &mut memory.bos,
        &mut [],
        &mut memory.control,
    );
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET_LEN);
    let (sender, receiver) = class.split();
    let reader = Reader(receiver.into_buffered(&mut memory.received));
    spawner.spawn(once(device(builder.build())));
    spawner.spawn(once(transmit(shared, Writer { sender, full: false })));
    spawner.spawn(once(receive(shared, reader)));
}

#[embassy_executor::task]
async fn device(mut device: UsbDevice<'static, Otg>) {
    device.run().await;
}

#[embassy_executor::task]
async fn transmit(shared: &'static BoardShared, writer: Writer) {
    link::transmit(shared, writer).await;
}

#[embassy_executor::task]
async fn receive(shared: &'static BoardShared, reader: Reader) {
    link::receive(shared, reader).await;
}

/// Reads from the host; waits while no host is connected.
struct Reader(BufferedReceiver<'static, Otg>);

impl ErrorType for Reader {
    type Error = core::convert::Infallible;
}

impl Read for Reader {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Self::Error> {
        loop {
            match self.0.read(buffer).await {
                Ok(len) => return Ok(len),
                Err(_) => self.0.wait_connection().await,
            }
        }
    }
}

/// Writes to the host. A flush ends the data with a packet that is not full: otherwise the host waits for more.
struct Writer {
    sender: Sender<'static, Otg>,
    full: bool,
}

/// No host is connected.
#[derive(Debug)]
struct NotConnected;

impl core::fmt::Display for NotConnected {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("no host is connected")
    }
}

impl core::error::Error for NotConnected {}

impl embedded_io_async::Error for NotConnected {
    fn kind(&self) -> embedded_io_async::ErrorKind {
        embedded_io_async::ErrorKind::NotConnected
    }
}

impl From<EndpointError> for NotConnected {
    fn from(_: EndpointError) -> Self {
        Self
    }
}

impl ErrorType for Writer {
    type Error = NotConnected;
}

impl Write for Writer {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        let len = bytes.len().min(PACKET_LEN.into());
        self.sender.write_packet(&bytes[..len]).await?;
        self.full = len == usize::from(PACKET_LEN);
        Ok(len)
    }

    async fn flush(&mut self) -> Result<(), Self::Error> {
        if core::mem::take(&mut self.full) {
            self.sender.write_packet(&[]).await?;
        }
        Ok(())
    }
}
