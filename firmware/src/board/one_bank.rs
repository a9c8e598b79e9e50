//! Chips with 512 KiB of flash in one bank: STM32F446xE and STM32F411xE.

/// Where the configuration lives: sectors 1 to 3, of 16 KiB each. The vectors are in sector 0 and
/// the program begins in sector 4: see `memory/one_bank.x`.
pub const STORE: core::ops::Range<u32> = 0x4000..0x1_0000;

/// The first one's number in the flash's control register.
pub const STORE_SECTOR: u8 = 1;

/// Whether the core stands still while the store is erased: there is one bank, which the program
/// runs from.
pub const ERASE_STALLS: bool = true;

/// These chips have no generator of random numbers: the store's count of starts has to do.
pub(in crate::board) fn random() -> Option<shared_proto::Nonce> {
    None
}
